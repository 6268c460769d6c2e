"""`check` inside a notebook says what the grader would say, at once."""

import html.parser

import numpy as np

from autograder.notebook import check
from mechlib import bracket

BY_CHECK = globals()


def brackets(f, a, b, n):
    return BY_CHECK["answer"](f, a, b, n)


def asked(answer, task="brackets"):
    BY_CHECK["answer"] = answer
    return check(task)


def test_a_right_answer_gets_its_points():
    assert repr(asked(bracket.brackets)).startswith("brackets: right, 2 of 2 points")


def test_a_known_mistake_is_named_with_a_place_to_look():
    card = repr(asked(lambda f, a, b, n: bracket.brackets(f, a, b, n - 1)))
    assert "The grid has n points, and not n subintervals. Count the fence posts" in card
    assert "To read: newton-1d: " in card


def test_a_public_case_tells_what_was_tried_and_what_the_exception_said():
    def fails(f, a, b, n):
        raise TypeError("unsupported operand")

    card = repr(asked(fails))
    assert "stopped with an error" in card
    assert "it raised TypeError, which says: unsupported operand (tried: 3 changes of sign on" in card


def test_a_gap_is_not_started():
    def gap(f, a, b, n):
        raise NotImplementedError

    assert repr(asked(gap)).startswith("brackets: not started, 0 of 2 points")


def test_a_function_that_is_not_there_is_not_started():
    assert "no cell defines newton" in repr(check("newton"))


def test_an_unknown_task_is_answered_with_those_that_exist():
    assert repr(check("bracket")).startswith(
        "there is no task 'bracket': there are brackets, newton_1d, failures, order, "
        "newton, jacobian_fd, jacobian_errors, basin_map"
    )


def test_an_answer_may_change_what_it_was_handed():
    def spoils(residual, x):
        x *= 0
        return np.zeros((2, 2))

    BY_CHECK["jacobian_fd"] = spoils
    first = repr(check("jacobian_fd"))
    assert repr(check("jacobian_fd")) == first


class Tags(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.seen = []

    def handle_starttag(self, tag, attrs):
        self.seen.append((tag, dict(attrs)))


def test_the_card_is_html_without_script_and_escapes_what_a_student_wrote():
    def hostile(f, a, b, n):
        raise ValueError("<script>alert(1)</script><img src=x onerror=alert(1)>")

    tags = Tags()
    tags.feed(asked(hostile)._repr_html_())
    assert {tag for tag, _ in tags.seen} <= {"section", "p", "strong", "span", "ul", "li", "em"}
    assert not any(name.startswith("on") for _, attributes in tags.seen for name in attributes)
