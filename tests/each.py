"""One item for many values: a check of each file needs no item for each."""

import inspect


def each(names, values):
    """A test that tries all values, as one item that tells of each that fails.

    Parameters
    ----------
    names : str
        The arguments that a value fills, as in `pytest.mark.parametrize`; the
        test's other arguments are fixtures.
    values : iterable
        The values; tuples for several names.
    """
    names, values = names.split(", "), list(values)
    if not values:
        raise ValueError(f"no value for {names}: nothing would be tested")

    def one_item(test):
        def together(**fixtures):
            faults = []
            for value in values:
                given = dict(zip(names, value if len(names) > 1 else [value]))
                try:
                    test(**given, **fixtures)
                except Exception as fault:
                    fault.add_note(f"{names[0]} = {given[names[0]]}")
                    faults.append(fault)
            if faults:
                tried = f"{len(faults)} of {len(values)} values fail"
                raise ExceptionGroup(tried, faults)

        arguments = inspect.signature(test).parameters.values()
        fixtures = [x for x in arguments if x.name not in names]
        together.__signature__ = inspect.Signature(fixtures)
        together.__name__, together.__doc__ = test.__name__, test.__doc__
        together.__module__ = test.__module__
        return together

    return one_item
