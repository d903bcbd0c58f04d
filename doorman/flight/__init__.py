"""Flight: what surrounds a mission on a vehicle, from the checklist on the ground to the ground again."""

from doorman.flight.ends import End
from doorman.flight.flying_backend import FlyingBackend
from doorman.flight.ground.checklist import preflight
from doorman.flight.ground.judgements import Check, Verdict, ready
from doorman.flight.ground.listening import listen
from doorman.flight.ground.rehearsal import rehearse
from doorman.flight.guarded import GuardedFlight
from doorman.flight.session import FlightReport, FlightSession

__all__ = [
    "Check",
    "End",
    "FlightReport",
    "FlightSession",
    "FlyingBackend",
    "GuardedFlight",
    "Verdict",
    "listen",
    "preflight",
    "ready",
    "rehearse",
]
