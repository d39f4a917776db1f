"""A hunt for differences between the package, its checker and the page's solver.

Each of the three reads a request or a proof by itself. `requests` makes plants and
requests that no other test uses, `tampering` changes proofs, `readers` asks all three,
and ``python3 tasks.py hunt`` goes on until its time is over. What it looks for:

- a claim that isn't true, by eigenvalues;
- a proof that one reader accepts and another one refuses, or words that differ;
- a verdict that contradicts another's, or its own in other units.
"""
