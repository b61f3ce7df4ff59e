// SPDX-License-Identifier: Apache-2.0
#include "study/optimise/local_search.hpp"

#include <algorithm>
#include <exception>
#include <nlopt.hpp>

namespace fringetwin::study {
namespace {

/// NLopt asks for objective and constraints one after the other, and lets no exception of ours through.
class Adapter {
 public:
  explicit Adapter(const LocalFunction& function) : function_(function) {}

  static double objective(const std::vector<double>& x, std::vector<double>&, void* self) {
    return static_cast<Adapter*>(self)->at(x.data(), x.size()).objective;
  }
  static void excess(unsigned m, double* out, unsigned n, const double* x, double*, void* self) {
    const LocalValue& value = static_cast<Adapter*>(self)->at(x, n);
    std::copy_n(value.excess.begin(), m, out);
  }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  const LocalValue& at(const double* x, std::size_t n) {
    const std::vector<double> place(x, x + n);
    if (place == place_) return value_;
    try {
      value_ = function_(place);
    } catch (const EnoughOfIt&) {
      throw nlopt::forced_stop();
    } catch (...) {
      error_ = std::current_exception();
      throw nlopt::forced_stop();
    }
    place_ = place;
    return value_;
  }

  const LocalFunction& function_;
  std::vector<double> place_;
  LocalValue value_;
  std::exception_ptr error_;
};

}  // namespace

void local_search(const LocalFunction& function, std::vector<double> start, std::size_t constraints,
                  double step, double least_step) {
  Adapter adapter(function);
  nlopt::opt search(nlopt::LN_COBYLA, static_cast<unsigned>(start.size()));
  search.set_lower_bounds(0.0);
  search.set_upper_bounds(1.0);
  search.set_min_objective(Adapter::objective, &adapter);
  if (constraints > 0)
    search.add_inequality_mconstraint(Adapter::excess, &adapter, std::vector<double>(constraints, 0.0));
  search.set_initial_step(step);
  search.set_xtol_abs(least_step);
  double least = 0.0;
  try {
    search.optimize(start, least);
  } catch (const nlopt::forced_stop&) {
    adapter.rethrow();
  } catch (const nlopt::roundoff_limited&) {
    // as near as it gets
  }
}

}  // namespace fringetwin::study
