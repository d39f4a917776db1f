"""Loops as they are, without an input."""

import sosbook as sos


def analyse_loop(E, A, B_w=None, C=None, **asked):
    """The `Design` of what is ``asked`` of E x' = A x + B_w w, y = C x."""
    return sos.analyse_pid(sos.DescriptorSystem(E, A, None, B_w, C), **asked)
