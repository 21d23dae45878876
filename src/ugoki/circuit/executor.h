#pragma once
// Interface to the host's threads, on which an interpreter can run independent LSIs. The runtime itself creates no thread.

#include "ugoki/base/executor.h"

namespace ugoki::circuit {

class Executor : public ugoki::Executor {};

}  // namespace ugoki::circuit
