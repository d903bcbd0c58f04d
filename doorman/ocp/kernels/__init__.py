"""What solvers call: functions of a model, by hand, from Python or printed from symbols."""

from doorman.ocp.kernels import default_curvature as default_curvature
from doorman.ocp.kernels import defaults as defaults
