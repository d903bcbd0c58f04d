"""What solvers call: functions of a model, by hand, from Python or printed from symbols."""

from doorman.ocp.kernels import defaults as defaults
