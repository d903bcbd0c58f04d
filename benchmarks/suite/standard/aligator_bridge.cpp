// aligator's ProxDDP on a standard problem, whose functions are CasADi's generated C (`aligator_program.py`); for ctypes.

#include <chrono>
#include <cstring>
#include <vector>

#include <aligator/core/cost-abstract.hpp>
#include <aligator/core/explicit-dynamics.hpp>
#include <aligator/core/traj-opt-problem.hpp>
#include <aligator/modelling/constraints.hpp>
#include <aligator/solvers/proxddp/solver-proxddp.hpp>

#define GENERATED(name)                                                            \
  int name(const double **, double **, long long *, double *, int);                \
  int name##_work(long long *, long long *, long long *, long long *);
extern "C" {
GENERATED(next)
GENERATED(next_slopes)
GENERATED(first_rows)
GENERATED(first_rows_slopes)
GENERATED(rows)
GENERATED(rows_slopes)
GENERATED(last_rows)
GENERATED(last_rows_slopes)
GENERATED(stage)
GENERATED(stage_gradient)
GENERATED(stage_hessian)
GENERATED(end)
GENERATED(end_gradient)
GENERATED(end_hessian)
}

namespace {
using aligator::context::MatrixXs;
using aligator::context::VectorXs;
using Vector = aligator::context::ConstVectorRef;
using Space = aligator::VectorSpaceTpl<double>;

// A generated function with its memory: of (x, u, q), one dense result, column by column.
class Generated {
public:
  using Call = int (*)(const double **, double **, long long *, double *, int);
  using Work = int (*)(long long *, long long *, long long *, long long *);

  Generated(Call call, Work work) : call_(call) {
    long long arguments, results, integers, numbers;
    work(&arguments, &results, &integers, &numbers);
    arguments_.resize(arguments), results_.resize(results), integers_.resize(integers), numbers_.resize(numbers);
  }

  void operator()(const double *x, const double *u, const double *q, double *result) {
    arguments_[0] = x, arguments_[1] = u, arguments_[2] = q, results_[0] = result;
    call_(arguments_.data(), results_.data(), integers_.data(), numbers_.data(), 0);
  }

private:
  Call call_;
  std::vector<const double *> arguments_;
  std::vector<double *> results_;
  std::vector<long long> integers_;
  std::vector<double> numbers_;
};

#define FUNCTION(name) Generated g_##name(name, name##_work)
FUNCTION(next);
FUNCTION(next_slopes);
FUNCTION(first_rows);
FUNCTION(first_rows_slopes);
FUNCTION(rows);
FUNCTION(rows_slopes);
FUNCTION(last_rows);
FUNCTION(last_rows_slopes);
FUNCTION(stage);
FUNCTION(stage_gradient);
FUNCTION(stage_hessian);
FUNCTION(end);
FUNCTION(end_gradient);
FUNCTION(end_hessian);

// x⁺; q points to the parameters of its node.
struct Dynamics : aligator::context::ExplicitDynamics {
  using Base = aligator::context::ExplicitDynamics;
  using Data = aligator::context::ExplicitDynamicsData;
  const double *q;
  Dynamics(const Space &space, int nu, const double *q) : Base(space, nu), q(q) {}
  void forward(const Vector &x, const Vector &u, Data &data) const override {
    g_next(x.data(), u.data(), q, data.xnext_.data());
  }
  void dForward(const Vector &x, const Vector &u, Data &data) const override {
    g_next_slopes(x.data(), u.data(), q, data.jac_buffer_.data());
  }
};

// Rows that must not be positive.
struct Rows : aligator::context::StageFunction {
  using Base = aligator::context::StageFunction;
  using Data = aligator::context::StageFunctionData;
  Generated *values, *slopes;
  const double *q;
  Rows(int nx, int nu, int count, Generated &values, Generated &slopes, const double *q)
      : Base(nx, nu, count), values(&values), slopes(&slopes), q(q) {}
  void evaluate(const Vector &x, const Vector &u, Data &data) const override {
    (*values)(x.data(), u.data(), q, data.value_.data());
  }
  void computeJacobians(const Vector &x, const Vector &u, Data &data) const override {
    (*slopes)(x.data(), u.data(), q, data.jac_buffer_.data());
  }
};

// Those entries of [x; u] that have bounds.
struct Entries : aligator::context::StageFunction {
  using Base = aligator::context::StageFunction;
  using Data = aligator::context::StageFunctionData;
  std::vector<int> places;
  Entries(int nx, int nu, const std::vector<int> &places) : Base(nx, nu, int(places.size())), places(places) {}
  void evaluate(const Vector &x, const Vector &u, Data &data) const override {
    for (size_t i = 0; i < places.size(); i++)
      data.value_[i] = places[i] < ndx1 ? x[places[i]] : u[places[i] - ndx1];
  }
  void computeJacobians(const Vector &, const Vector &, Data &data) const override {
    for (size_t i = 0; i < places.size(); i++)
      data.jac_buffer_(i, places[i]) = 1.0;
  }
};

// Half squares; their Hessian is that of Gauss and Newton.
struct Squares : aligator::context::CostAbstract {
  using Base = aligator::context::CostAbstract;
  using Data = aligator::context::CostData;
  Generated *value, *gradient, *hessian;
  const double *q;
  Squares(const Space &space, int nu, Generated &value, Generated &gradient, Generated &hessian, const double *q)
      : Base(space, nu), value(&value), gradient(&gradient), hessian(&hessian), q(q) {}
  void evaluate(const Vector &x, const Vector &u, Data &data) const override {
    (*value)(x.data(), u.data(), q, &data.value_);
  }
  void computeGradients(const Vector &x, const Vector &u, Data &data) const override {
    (*gradient)(x.data(), u.data(), q, data.grad_.data());
  }
  void computeHessians(const Vector &x, const Vector &u, Data &data) const override {
    (*hessian)(x.data(), u.data(), q, data.hess_.data());
  }
};

using Stage = aligator::context::StageModel;
using Problem = aligator::context::TrajOptProblem;
using Solver = aligator::SolverProxDDPTpl<double>;

// Bounds of [x; u], of which those at `first` and after count.
struct Bounds {
  std::vector<int> places;
  std::vector<double> lower, upper;
  Bounds(const double *low, const double *high, int first, int end) {
    for (int i = first; i < end; i++)
      if (std::isfinite(low[i]) || std::isfinite(high[i]))
        places.push_back(i), lower.push_back(low[i]), upper.push_back(high[i]);
  }
  aligator::BoxConstraintTpl<double> set() const {
    return {Eigen::Map<const VectorXs>(lower.data(), lower.size()), Eigen::Map<const VectorXs>(upper.data(), upper.size())};
  }
};

struct Program {
  int n, nx, nu, nq;
  std::vector<double> q;
  Problem problem;
  Solver solver;
  double penalty, replan_penalty;
  int most;
};

Problem made(int n, int nx, int nu, int nq, const int *counts, const double *low, const double *high, const double *q) {
  const Space space(nx);
  std::vector<xyz::polymorphic<Stage>> stages;
  for (int k = 0; k < n; k++) {
    const double *own = q + k * nq;
    Stage stage(Squares(space, nu, g_stage, g_stage_gradient, g_stage_hessian, own), Dynamics(space, nu, own));
    const int count = k ? counts[1] : counts[0];
    if (count)
      stage.addConstraint(Rows(nx, nu, count, k ? g_rows : g_first_rows, k ? g_rows_slopes : g_first_rows_slopes, own),
                          aligator::NegativeOrthantTpl<double>());
    const Bounds bounds(low, high, k ? 0 : nx, nx + nu);
    if (!bounds.places.empty())
      stage.addConstraint(Entries(nx, nu, bounds.places), bounds.set());
    stages.push_back(stage);
  }
  const double *own = q + n * nq;
  Problem problem(VectorXs::Zero(nx), stages, Squares(space, 0, g_end, g_end_gradient, g_end_hessian, own));
  if (counts[2])
    problem.addTerminalConstraint(Rows(nx, 0, counts[2], g_last_rows, g_last_rows_slopes, own),
                                  aligator::NegativeOrthantTpl<double>());
  const Bounds bounds(low, high, 0, nx);
  if (!bounds.places.empty())
    problem.addTerminalConstraint(Entries(nx, 0, bounds.places), bounds.set());
  return problem;
}

// The multipliers one step later; those of the first and the last node have other sizes.
void shift(std::vector<VectorXs> &each) {
  for (size_t k = 1; k + 1 < each.size(); k++)
    if (each[k].size() == each[k + 1].size())
      each[k] = each[k + 1];
}
} // namespace

extern "C" {
// counts: rows at the first node, between, and at the last; bounds of [x; u].
Program *create(int n, int nx, int nu, int nq, const int *counts, const double *low, const double *high, double tolerance,
                double penalty, double replan_penalty, int most) {
  std::vector<double> q((n + 1) * (nq + 1), 0.0);
  const double *place = q.data();
  auto *program = new Program{n, nx, nu, nq, std::move(q), made(n, nx, nu, nq, counts, low, high, place), Solver(tolerance),
                              penalty, replan_penalty, most};
  program->solver.setup(program->problem);
  return program;
}

// From a guess, which the solution replaces; warm: one iteration with the shifted multipliers of the solve before.
// Returns seconds, negative where it failed.
double solve(Program *program, const double *start, const double *q, double *states, double *inputs, int warm,
             int *iterations, int *converged) {
  auto &[n, nx, nu, nq, own, problem, solver, penalty, replan_penalty, most] = *program;
  std::memcpy(own.data(), q, sizeof(double) * (n + 1) * nq);
  problem.setInitState(Eigen::Map<const VectorXs>(start, nx));
  std::vector<VectorXs> xs, us, vs, lams;
  for (int k = 0; k <= n; k++)
    xs.push_back(Eigen::Map<const VectorXs>(states + k * nx, nx));
  for (int k = 0; k < n; k++)
    us.push_back(Eigen::Map<const VectorXs>(inputs + k * nu, nu));
  xs[0] = Eigen::Map<const VectorXs>(start, nx);
  vs = solver.results_.vs, lams = solver.results_.lams;
  if (warm)
    shift(vs), shift(lams);
  else
    for (auto *each : {&vs, &lams})
      for (auto &one : *each)
        one.setZero();
  solver.mu_init_ = warm ? replan_penalty : penalty;
  solver.max_iters = warm ? 1 : most;
  const auto begun = std::chrono::steady_clock::now();
  try {
    solver.run(problem, xs, us, vs, lams);
  } catch (const std::exception &) {
    return -1.0;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  for (int k = 0; k <= n; k++)
    Eigen::Map<VectorXs>(states + k * nx, nx) = solver.results_.xs[k];
  for (int k = 0; k < n; k++)
    Eigen::Map<VectorXs>(inputs + k * nu, nu) = solver.results_.us[k];
  *iterations = int(solver.results_.num_iters), *converged = solver.results_.conv;
  return seconds;
}
}
