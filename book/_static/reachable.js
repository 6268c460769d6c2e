// What scrolls sideways in a box of its own must be reachable by the keyboard: a formula that is wider than the page.
(() => {
  const reach = () => {
    for (const box of document.querySelectorAll("mjx-container[display], .cell_output .text_html, div.math")) {
      if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
      else box.removeAttribute("tabindex");
    }
  };
  addEventListener("load", async () => {
    await window.MathJax?.startup?.promise;
    new ResizeObserver(reach).observe(document.documentElement);
  });
})();
