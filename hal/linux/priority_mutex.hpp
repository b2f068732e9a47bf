#pragma once
#include <memory>

#include "hal/mutex.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// POSIX: a mutex with PTHREAD_PRIO_INHERIT (IEEE Std 1003.1-2017, pthread_mutexattr_setprotocol).
/// Errors:  not_supported.
Result<std::unique_ptr<Mutex>> priority_mutex();

}  // namespace sinew::hal
