"""Is every number that is typed in the book's prose tied to something?

A number in the text is *tied* if an output of its page prints it, rounded as
written, or a code cell of the page sets it, or it is thesis data, or a list
of given data in ``tests/given`` says where it comes from. What is tied to
nothing drifts unnoticed, and is reported::

    python -m tests.prose book/05_hinf.ipynb      a page's report
"""
