// SPDX-License-Identifier: Apache-2.0
// One function object out of several lambdas, as a visitor of a std::variant with one lambda per alternative.
#pragma once

namespace fringetwin {

/// Give std::visit one lambda per alternative and no generic one: then an alternative that somebody adds
/// later does not compile until it has its own.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace fringetwin
