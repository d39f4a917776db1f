"""What speaks against a log or a fit."""

from dataclasses import dataclass

__all__ = ["Finding", "refusal", "refused", "warning"]


@dataclass(frozen=True)
class Finding:
    """Something about the logs that a working robot doesn't do.

    ``severity``, {"refused", "warning"}: whether it forbids a program; ``subject``: the
    log or the fit; ``text``: what is wrong, and what it may come from.
    """

    severity: str
    subject: str
    text: str

    def __str__(self):
        return f"{self.subject}: {self.text}"


def refusal(subject, text):
    """A `Finding` about a ``subject`` that forbids a program; the ``text`` says why."""
    return Finding("refused", subject, text)


def warning(subject, text):
    """A `Finding` about a ``subject`` that forbids nothing; the ``text`` says what."""
    return Finding("warning", subject, text)


def refused(findings):
    """The findings that forbid a program, unless it is forced."""
    return [f for f in findings if f.severity == "refused"]
