"""Copies and pickles: each public object comes out as good as it went in, or says in a sentence that it does not."""

from __future__ import annotations

import copy
import dataclasses
import enum
import gc
import importlib
import inspect
import multiprocessing
import pickle
import pkgutil
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pydantic
import pytest
from at_the_door import AT_THE_DOOR
from numpy.typing import NDArray

import doorman
from doorman import Model, Planner, Scenario
from doorman.collision.scene import CollisionScene
from doorman.copying import Uncopied
from doorman.exceptions import SolverError
from doorman.hardware.safety import Assessor
from doorman.ocp import Bounds, Cddp, Hybrid, Problem, PythonModel, QuadraticCost, SolverOptions, SymbolicModel
from doorman.recording import Recording, Topic

Array = NDArray[np.float64]

COPIES: dict[str, Callable[[Any], Any]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
}
ABSTRACT = {"Solver", "Observer", "PoseSource", "DoorSource"}
"""A base of the solvers below; what keeps the eye on a vehicle's backend, which refuses; and what cameras and sensors are."""


def public_classes() -> dict[str, type]:
    """Classes that packages export, without those that are data, and errors."""
    names = [info.name for info in pkgutil.walk_packages(doorman.__path__, "doorman.") if info.ispkg]
    found = {}
    for package in map(importlib.import_module, ["doorman", *names]):
        for name in getattr(package, "__all__", ()):
            one = getattr(package, name)
            plain = (BaseException, enum.Enum, pydantic.BaseModel, tuple)
            if inspect.isclass(one) and not issubclass(one, plain) and not dataclasses.is_dataclass(one):
                found[name] = one
    return found


REFUSING = {name: one for name, one in public_classes().items() if issubclass(one, Uncopied)}


@cache
def model() -> Model:
    return Model(Scenario.load("paper", AT_THE_DOOR))


def state() -> Array:
    x = model().start_state.copy()
    x[0] += 0.02
    x[3] -= 0.05
    return x


@cache
def problem() -> Problem:
    return Planner(model()).solver.problem


OPTIONS = SolverOptions(hessian="gauss-newton")
"""Whose kernels are the planner's."""
ARM = np.array([0.0, 1.0, -0.6, -0.4])


def planned(planner: Planner) -> list[Array]:
    plan = planner.plan(state())
    again = planner.replan(plan.states[1])
    return [plan.states, plan.inputs, again.states, again.inputs, np.array([plan.cost, again.cost])]


def solved(solver: Any) -> list[Array]:
    solution = solver.solve(state(), max_iterations=5)
    return [solution.states, solution.inputs, *solution.multipliers, np.array([solution.cost])]


def modelled(one: Model) -> list[Array]:
    x, u = state(), one.hover_input
    return [one.constraints(x), one.constraint_jacobian(x), one.step(x, u), *one.step_jacobian(x, u), one.goal_state]


def clearances(scene: CollisionScene) -> list[Array]:
    distance = scene.min_clearance([0.1, -0.5, 0.8], np.eye(3), ARM, 1.2).distance
    return [np.array([distance]), np.array(scene.pairs)]


OWNERS: dict[str, tuple[Callable[[], Any], Callable[[Any], list[Array]]]] = {
    "Model": (model, modelled),
    "Vehicle": (lambda: model().vehicle, lambda one: [one.point_jacobians(ARM), one.inertia(ARM)]),
    "Door": (lambda: model().door, lambda one: [one.link_placements(1.0)["leaf"]]),
    "Coupling": (lambda: model().coupling, lambda one: [one.vehicle_position([0.1, 0.0, 0.2], 1.2, ARM)]),
    "CollisionScene": (lambda: CollisionScene(model().vehicle, model().door), clearances),
    "Planner": (lambda: Planner(model()), planned),
    "Hybrid": (lambda: Hybrid(problem(), OPTIONS), solved),
    "Cddp": (lambda: Cddp(problem(), OPTIONS), solved),
    "Problem": (problem, lambda one: solved(Hybrid(one, OPTIONS))),
    "Topic": (lambda: Topic("t", np.arange(3.0), {"a": np.ones(3)}), lambda one: [one.time, one["a"]]),
    "Recording": (lambda: Recording({}, {"a": 1}), lambda one: [np.array([one.complete])]),
    "Assessor": (lambda: Assessor(model().scenario.safety), lambda one: [np.array(sorted(vars(one)))]),
}
"""How each is made, and what it answers."""


def same(ones: list[Array], others: list[Array]) -> None:
    for one, other in zip(ones, others, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_symbolic_model_refuses_in_a_sentence(way):
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    with pytest.raises(TypeError, match="its problems can"):
        way(SymbolicModel(x, u, u))


def test_every_public_class_says_what_its_copies_are():
    unknown = public_classes().keys() - REFUSING.keys() - OWNERS.keys() - ABSTRACT - {"SymbolicModel"}
    assert unknown == set()
    assert len(REFUSING) >= 10


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("name", OWNERS)
def test_a_copy_answers_as_the_original_would_and_leaves_it_alone(name, make):
    build, answer = OWNERS[name]
    expected = answer(build())
    original = build()
    first, second = make(original), make(original)
    same(answer(first), expected)
    same(answer(first), answer(make(first)) if name not in ("Model", "Planner") else answer(first))
    same(answer(original), expected)
    del original, first
    gc.collect()
    rubbish = [np.full(20000, 1e7) for _ in range(20)]
    same(answer(second), expected)
    assert len(rubbish) == 20


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("refusing", REFUSING.values(), ids=REFUSING)
def test_what_holds_a_device_refuses_in_a_sentence(refusing, make):
    one = refusing.__new__(refusing) if not inspect.isabstract(refusing) else None
    if one is None:
        one = object.__new__(type(refusing.__name__, (refusing,), dict.fromkeys(refusing.__abstractmethods__)))
    with pytest.raises(TypeError, match=f"{refusing.__name__} cannot be copied or pickled.*make another"):
        make(one)


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
def test_a_copied_planner_goes_on_where_the_original_is(make):
    """With its hinge, its margin and its previous plan."""
    original, twin = Planner(model()), Planner(model())
    for planner in (original, twin):
        planner.update_door(friction=0.4, disturbance=-0.2)
        planner.update_margin(0.03)
        following = planner.plan(state()).states[1]
    one = make(original)
    one.update_door(friction=2.0)
    one.plan(model().start_state)
    other = make(original)
    expected = twin.replan(following)
    for planner in (other, original):
        plan = planner.replan(following)
        same([plan.states, plan.inputs], [expected.states, expected.inputs])
        assert (plan.cost, plan.status, plan.iterations) == (expected.cost, expected.status, expected.iterations)
        assert planner.margin == 0.03


def work(order: tuple[Planner, Array]) -> Array:
    planner, x = order
    return planner.plan(x).inputs


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_pool_of_processes_plans_as_this_one_does(method):
    planner = Planner(model())
    with multiprocessing.get_context(method).Pool(1) as pool:
        found = pool.map_async(work, [(planner, state()), (planner, model().start_state)]).get(60.0)
    same(found, [Planner(model()).plan(state()).inputs, Planner(model()).plan(model().start_state).inputs])


class Steps:
    """A step that fails from some time on."""

    fails = False

    def __call__(self, x: Array, u: Array) -> Array:
        if self.fails:
            raise SolverError("on purpose")
        return np.array([x[0] + 0.1 * x[1], x[1] + 0.1 * u[0]])


def too_fast(x: Array) -> float:
    return float(x[1] - 0.7)


@pytest.mark.slow
def test_solvers_of_python_functions_keep_their_failures_apart():
    step, bounds = Steps(), Bounds(input_lower=[-1.0], input_upper=[1.0])  # of the tutorial's cart, whose kernels serve
    cost = QuadraticCost(np.ones(2), 10.0 * np.ones(2), np.ones(1), np.array([1.0, 0.0]), np.zeros(1))
    failing = Hybrid(PythonModel(step=step, constraints=too_fast).problem(cost, 10, 0.1, bounds))
    copied, pickled = copy.deepcopy(failing), pickle.loads(pickle.dumps(failing))
    expected = pickled.solve(np.zeros(2)).inputs
    step.fails = True
    with pytest.raises(SolverError, match="on purpose"):
        failing.solve(np.zeros(2))
    same([copied.solve(np.zeros(2)).inputs], [expected])
    step.fails = False
    same([failing.solve(np.zeros(2)).inputs], [expected])


# ---------------------------------------------------------------- threads


def in_threads(jobs: list[Callable[[], list[Array]]]) -> list[list[Array]]:
    """Results of jobs that all begin at once."""
    results: list[list[Array]] = [[] for _ in jobs]
    barrier = threading.Barrier(len(jobs))

    def run(index: int) -> None:
        barrier.wait(30.0)
        results[index] = jobs[index]()

    threads = [threading.Thread(target=run, args=(index,)) for index in range(len(jobs))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    return results


def test_threads_share_a_model():
    """Each of its own arm and door angles, all at the same time."""
    shared = model()

    def answers(seed: int) -> list[Array]:
        rng, found = np.random.default_rng(seed), []
        for _ in range(60):
            x = state()
            x[3:] += 0.1 * rng.normal(size=len(x) - 3)
            u = shared.hover_input + 0.1 * rng.normal(size=shared.nu)
            found += [shared.constraints_along(np.tile(x, (200, 1))), shared.step(x, u), *shared.step_jacobian(x, u)]
            found += [shared.vehicle.point_jacobians(x[5:]), shared.door.link_placements(x[3])["leaf"]]
        return found

    expected = [answers(seed) for seed in range(4)]
    for found, alone in zip(in_threads([lambda s=s: answers(s) for s in range(4)]), expected, strict=True):
        same(found, alone)


def test_solvers_of_one_problem_run_in_threads():
    starts = [model().start_state, state(), model().start_state]

    def solve(solver: Hybrid, x: Array) -> list[Array]:
        solution = solver.solve(x, max_iterations=30)
        return [solution.states, solution.inputs]

    expected = [solve(Hybrid(problem(), OPTIONS), x) for x in starts]
    solvers = [Hybrid(problem(), OPTIONS) for _ in starts]
    for _ in range(3):
        jobs = [lambda s=s, x=x: solve(s, x) for s, x in zip(solvers, starts, strict=True)]
        for found, alone in zip(in_threads(jobs), expected, strict=True):
            same(found, alone)
