// SPDX-License-Identifier: Apache-2.0
#include "twin/base/parallel.hpp"

#include <atomic>
#include <exception>
#include <vector>

#include "twin/base/progress.hpp"

namespace fringetwin {

void for_each_parallel(int n, const std::function<void(int)>& job) {
  std::vector<std::exception_ptr> faults(n);
  std::atomic<int> lowest_fault = n;
#pragma omp parallel for schedule(dynamic)
  for (int i = 0; i < n; ++i) {
    if (i > lowest_fault) continue;
    try {
      throw_if_cancelled();
      job(i);
    } catch (...) {  // no exception may leave an OpenMP loop
      faults[i] = std::current_exception();
      for (int lowest = lowest_fault; i < lowest && !lowest_fault.compare_exchange_weak(lowest, i);) {
      }
    }
  }
  for (const std::exception_ptr& fault : faults)
    if (fault) std::rethrow_exception(fault);
}

}  // namespace fringetwin
