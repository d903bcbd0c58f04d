"""Words of the page of results."""

from __future__ import annotations

INTRODUCTION = """# Benchmarks

doorman's planner against other solvers: the same problem, the same states, the same core, one run. acados and aligator are
built from their sources for this processor, the others are wheels. This page is written by `make bench`.
`benchmarks/README.md` says how each solver is set up and what is unfair about each row. Absolute times belong to one
machine and one hour of it: read ratios.

**Clocks.** For doorman the whole call counts, by the clock on the wall. For acados its own clock `time_tot` counts, for aligator
the duration of its `run`, and for the others the solver's call alone.
"""

COLD = """The paper's door, N = 50, Δt = 0.02 s, six inequalities at every node, no margin. States along the closed loop,
each solved from hover inputs. Times are those that the solver had the core, the best of three calls in a row. *Solved*
means: cost within 1e-6 of an interior-point reference (or below it), constraints and dynamics within 1e-6. Only solved
states count in times and ratios; ratios are taken state by state."""

LIMITS = """The same with limits of thrust, body rates, joint rates, joint angles and tilt at every node, as doorman's
scenarios have them by default."""

DOORS = """Doors drawn at random by seed; nothing is tuned to the paper's door:

| what | drawn |
| --- | --- |
| leaf | 1.1–1.5 m, 6–20 kg |
| contact | 0.55 m to D_w − 0.5 m from the hinge |
| damping | up to 0.8 N m s/rad |
| friction, every second door | up to 0.8 N m |"""

REPLANS = """One iteration from the shifted previous plan at each of 150 steps, several times over. For doorman the whole
call `Planner.replan(state)` counts, by the clock on the wall; for the others the solver's call alone, without shifting and
without taking the result apart. Every solver flies its 150 steps in a row, then the next has its turn. *Caches cold*: they
take turns after every step, so that each finds its data out of the cache. A call is interrupted if the scheduler took the
core away while it ran. *Suboptimality* is the relative difference of the cost from that of the converged optimum at the
same state."""

DISTURBED = (
    """The same with noise on the state after every step: standard deviation 0.01, 0.03 rad/s on the door's rate."""
)

PERTURBED = """States of the loop with random errors of posture, attitude and rates, each solved from hover inputs. A plan in
another local minimum is optimal, but IPOPT from hover inputs finds a better one. A plan that is less optimal than it says
holds, and the solver calls it converged. Its cost is more than 1e-6 above the reference's. A plan on the way back is outside
the constraints at first, inside at the end, and labelled so. Where a solver failed and said so, it calls its answer unusable.
Slow solvers get the first of doorman's states."""

SIZES = """Median times of solved states; where not all are solved, how many are. doorman solves all states, the others
every tenth of them."""

PHASES = """Every kernel of doorman's iteration called by itself from Python, again and again at the same 16 points of the
loop; medians. A call from Python costs about 0.3 µs, which is in these figures. *Python* is what the whole call takes
beyond its kernels: checks, copies of the trajectory, the plan."""

FLOOR = """Operations that one iteration cannot do without, counted from the problem's expressions, against fused multiply-adds in
registers on the same core. Zeros of the Jacobians are left out; a division or root counts as 4, a sine as 16. Chains of
dependent roots and divisions, loads, stores and shuffles are not counted: no program reaches this floor."""

PUSH = """Replans of three problems:

- the scenario `push`, whose tip can only push: friction cone, slip, edge, door rate, stopping and all limits at every node;
- the scenario `paper` with its limits;
- the paper's problem with six inequalities at a node.

Each flies closed loops of its own plans, without noise and with that from above; they take turns. Times are whole calls by the
clock on the wall. Every call has 8 ms (`time_limit`). *Late* is longer than the 10 ms of a planner at 100 Hz. *Not
flyable* says that no plan that holds was found by then; the plan says so, too."""

FRESH = """From the start of the interpreter to the first plan of the scenario `paper`, kernels compiled before; the worst
of several processes."""

REAL_TIME = """The scenario `paper` with its margin and limits. Planner at 1 kHz in one process and on one core; plant and
controller in another, on another core. Every call is given 0.7 ms (`time_limit`). A plan that is not there when the next one
is due, for whatever reason, is a missed deadline. *Missed though fast*: the plan itself took less than half the period, so
that the system held it up."""

NOTHING = """The same machine's ticks at the same rate, for as long and with real-time priority where it is permitted, in a
process that has nothing to do: what it misses, nobody could have kept. Missed: begun when the next was due."""

CONTROL_LOOP = """One mission of either kind of contact, against the clock: estimator, state machine, controller and
recorder at 200 Hz, the planner in a thread of its own at 100 Hz. The plant is the simulator, which takes its time in the
controller's ticks; there are no links. How far the periods are off 5 ms; a missed tick is one that was left out since the one
before took too long."""

MEETING = """Both at the same states: those of closed loops of doorman's plans, without noise and with noise on every state. Each
replans from its own shifted plan, with the same numbers of the task. For doorman the whole call counts, for acados its own clock
`time_tot`. A plan of doorman may exceed constraints by 2e-3 [m, or 30 N] (`planning.tolerance`). *Gap* is that of the dynamics.
Cold plans begin with the state held and hover inputs."""
