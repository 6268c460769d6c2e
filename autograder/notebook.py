"""`check("task")` inside a notebook: the public cases, at once, with the grader's own comparing and diagnosis."""

import copy
import inspect

from autograder.checks import task
from autograder.judge import Assessment, Paper, assess, undefined
from autograder.outcome import Outcome, Raised, Value
from autograder.report import card_html, card_text
from autograder.spec import PUBLIC_SALT


class Card:
    """What a check has to say: a card in a notebook, text elsewhere."""

    def __init__(self, assessment: Assessment):
        self.assessment = assessment

    def __repr__(self) -> str:
        return card_text(self.assessment)

    def _repr_html_(self) -> str:
        return card_html(self.assessment)


class Unknown:
    """A task that does not exist: one sentence, and no traceback."""

    def __init__(self, sentence: str):
        self.sentence = sentence

    def __repr__(self) -> str:
        return self.sentence


def check(name: str) -> Card | Unknown:
    """Look at one task of the notebook, as the grader will, with inputs that everyone may see.

    Parameters
    ----------
    name : str
        The task, for example ``"brackets"``.

    Returns
    -------
    Card
        Its points, what was looked at, and which mistake it is; or a sentence with the tasks that exist.
    """
    try:
        wanted = task(name)
    except LookupError as missing:
        return Unknown(missing.args[0])
    namespace = inspect.currentframe().f_back.f_globals

    def call(function: str, args: tuple, kwargs: dict, seconds: float) -> Outcome:
        # the kernel is the student's own: no time limit but the stop button
        if not callable(namespace.get(function)):
            return Raised("NameError", ("Exception",), undefined(function))
        try:
            return Value(namespace[function](*copy.deepcopy(args), **copy.deepcopy(kwargs)))
        except Exception as mistake:
            return Raised.of(mistake)

    return Card(assess(Paper(wanted, wanted.draw(PUBLIC_SALT, "")), call, public=True))
