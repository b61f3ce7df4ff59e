// SPDX-License-Identifier: Apache-2.0
// Every public header is complete by itself and with the others.
#include "cosim/cosim.hpp"
#include "cosim/load.hpp"
#include "cosim/shape/measured_shapes.hpp"
#include "cosim/simulate.hpp"
#include "cosim/write_results.hpp"
#include "measure/measurement.hpp"
#include "render/base/device_info.hpp"
#include "render/renderer.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"
