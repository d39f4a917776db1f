"""The still picture of a widget, for pages without a kernel."""


class OnPage:
    """Gives a widget HTML for the pages; inherit from it before the widget.

    A subclass has ``html``, which stands in for it on a page, and ``text``, in a
    terminal.
    """

    def _repr_mimebundle_(self, **asked):
        bundle = super()._repr_mimebundle_(**asked)
        return {**bundle, "text/html": self.html, "text/plain": self.text}
