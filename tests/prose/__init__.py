"""Is every number that is typed in the book's prose tied to something?

It is *tied* if an output of its page prints it, rounded as written, or a cell sets it,
or ``tests/given`` says where it comes from. ``python -m tests.prose`` reports a page.
"""
