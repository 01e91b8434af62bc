#include "planner/happenings/linear_program.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/pddl/by_id.h"

namespace cxlab::planner {

namespace {

constexpr double kTiny = 1e-9;  ///< coefficients; rounding of sums of a few terms lies far below
constexpr double kMiss = 1e-7;  ///< by which a row may be missed

/// Rows of equations `x[basis] + sum of cells * x[others] = cells.back()`; the last two rows are the objectives.
class Tableau {
 public:
  Tableau(const std::vector<LinearRow>& rows, const std::vector<double>& objective)
      : rows_(static_cast<int>(rows.size())), variables_(static_cast<int>(objective.size())) {
    for (int r = 0; r < rows_; ++r) {
      cells_.push_back(rows[static_cast<std::size_t>(r)].coefficients);
      cells_[r].push_back(-1);  // of the slack that all rows share in the first phase
      cells_[r].push_back(rows[static_cast<std::size_t>(r)].bound);
      basis_.push_back(variables_ + 1 + r);
    }
    cells_.push_back(objective);
    cells_.back().resize(static_cast<std::size_t>(variables_) + 2, 0);
    cells_.emplace_back(static_cast<std::size_t>(variables_) + 2, 0.0);
    cells_.back()[static_cast<std::size_t>(variables_)] = 1;
    for (int v = 0; v <= variables_; ++v) others_.push_back(v);
  }

  std::optional<std::vector<double>> solve() {
    int worst = 0;
    for (int r = 1; r < rows_; ++r)
      if (bound(r) < bound(worst)) worst = r;
    if (rows_ > 0 && bound(worst) < -kTiny) {
      pivot(worst, variables_);
      if (!descend(rows_ + 1) || bound(rows_ + 1) < -kMiss) return std::nullopt;
      for (int r = 0; r < rows_; ++r) {
        if (basis_[r] != variables_) continue;
        int into = 0;
        for (int v = 1; v <= variables_; ++v)
          if (std::abs(cell(r, v)) > std::abs(cell(r, into))) into = v;
        if (std::abs(cell(r, into)) > kTiny) pivot(r, into);
      }
    }
    descend(rows_);
    std::vector<double> values(static_cast<std::size_t>(variables_), 0.0);
    for (int r = 0; r < rows_; ++r)
      if (basis_[r] < variables_) values[static_cast<std::size_t>(basis_[r])] = std::max(0.0, bound(r));
    return values;
  }

  /// Cells that were written when it was made, and looked at since.
  std::int64_t work() const { return work_ + std::int64_t{rows_ + 2} * (variables_ + 2); }

 private:
  double& cell(int row, int column) { return cells_[row][static_cast<std::size_t>(column)]; }
  double bound(int row) const { return cells_[row].back(); }

  void pivot(int row, int column) {
    work_ += std::int64_t{rows_ + 2} * (variables_ + 2);
    const double inverse = 1 / cell(row, column);
    for (int r = 0; r < rows_ + 2; ++r) {
      if (r == row || cell(r, column) == 0) continue;
      const double factor = cell(r, column) * inverse;
      for (int c = 0; c < variables_ + 2; ++c)
        if (c != column) cell(r, c) -= cell(row, c) * factor;
      cell(r, column) = -factor;
    }
    for (int c = 0; c < variables_ + 2; ++c)
      if (c != column) cell(row, c) *= inverse;
    cell(row, column) = inverse;
    std::swap(basis_[row], others_[column]);
  }

  /// Makes an objective least; false if it has no bound.
  bool descend(int objective) {
    const bool first_phase = objective == rows_ + 1;
    for (;;) {
      work_ += rows_ + variables_;
      int into = -1;
      for (int v = 0; v <= variables_; ++v) {
        if (!first_phase && others_[v] == variables_) continue;
        if (cell(objective, v) < -kTiny && (into < 0 || others_[v] < others_[into])) into = v;
      }
      if (into < 0) return true;
      int out = -1;
      double least = std::numeric_limits<double>::infinity();
      for (int r = 0; r < rows_; ++r) {
        if (cell(r, into) <= kTiny) continue;
        const double step = bound(r) / cell(r, into);
        if (out >= 0 && (step > least + kTiny || (step > least - kTiny && basis_[r] > basis_[out]))) continue;
        out = r;
        least = step;
      }
      if (out < 0) return false;
      pivot(out, into);
    }
  }

  const int rows_, variables_;
  ById<std::vector<double>> cells_;
  ById<int> basis_, others_;  ///< variables: those of the problem, the shared slack, then one slack by row
  std::int64_t work_ = 0;     ///< cells looked at
};

}  // namespace

std::optional<std::vector<double>> minimize(const std::vector<LinearRow>& rows, const std::vector<double>& objective,
                                            std::int64_t* work) {
  Tableau tableau(rows, objective);
  std::optional<std::vector<double>> values = tableau.solve();
  if (work) *work += tableau.work();
  return values;
}

}  // namespace cxlab::planner
