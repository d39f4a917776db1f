"""Memory of a design is free as soon as its answer is dropped, without a collection."""

import gc
import pickle

import pytest

import sosbook as sos
from benchmarks.catalogue import FAMILIES, case
from sosbook.exact.definite import exact
from sosbook.language.expression import Term, Unknown
from sosbook.plants.descriptor import Descriptor
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame

SMALL = Term, Unknown  # an unknown keeps itself as an expression

ASKED = {name: family for name, family in FAMILIES.items() if family.half == "tuning"}


def garbage_of(work):
    """Objects of the package that only a collection frees after ``work``."""
    work()  # what is made once for all, such as modules and caches
    gc.collect()
    gc.disable()
    try:
        work()
        gc.set_debug(gc.DEBUG_SAVEALL)
        gc.collect()
        return [o for o in gc.garbage if type(o).__module__.startswith("sosbook")]
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
        gc.enable()


@pytest.mark.parametrize("family", ASKED)
def test_a_design_leaves_no_garbage(family):
    question = case(family, ASKED[family].sizes[0], framed=True)
    found = garbage_of(lambda: question.design())
    assert [type(o).__name__ for o in found if not isinstance(o, SMALL)] == []


def test_a_refusal_leaves_no_garbage():
    plant, asked = FAMILIES["uncertain springs"].make(4)

    def refuse():
        design = sos.design_pid(plant, **asked | dict(gamma=1e-3))
        assert design.status == "infeasible" and design.infeasibility.proven

    found = garbage_of(refuse)
    assert [type(o).__name__ for o in found if not isinstance(o, SMALL)] == []


def test_vertices_are_moved_into_a_frame_once():
    plant, asked = FAMILIES["uncertain springs"].make(4)
    request = Request(plant, **asked)
    frame, other = Frame.of(request), Frame.of(request)
    known = request.vertices_at(frame)
    assert request.vertices_at(frame) is known is not request.vertices_at(other)
    for d, plain in zip(known, request.vertices, strict=True):
        moved = plain.change(frame.left, frame.T, frame.scale)
        assert (d.E == moved.E).all() and (d.Bu == moved.Bu).all()


def test_exact_vertices_are_moved_where_they_are_asked_for(monkeypatch):
    plant, asked = FAMILIES["uncertain springs"].make(16)
    request = Request(plant, **asked)
    moves, change = [], Descriptor.change

    def counted(d, *frame):
        moves.append(d)
        return change(d, *frame)

    monkeypatch.setattr(Descriptor, "change", counted)
    vertices = request.vertices_at(Frame.of(request), exact)
    moves.clear()
    assert len(vertices) == 16 and vertices[5] is vertices[5] and len(moves) == 1
    assert vertices[5].E.dtype == object


def test_moved_vertices_are_not_stored_with_a_request():
    plant, asked = FAMILIES["uncertain springs"].make(16)
    request = Request(plant, **asked)
    before = len(pickle.dumps(request))
    frame = Frame.of(request)
    request.vertices_at(frame)
    again = pickle.loads(pickle.dumps(request))
    assert len(pickle.dumps(request)) < 1.1 * before
    assert (again.vertices_at(frame)[3].A == request.vertices_at(frame)[3].A).all()
