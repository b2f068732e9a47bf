#include "hal/linux/priority_mutex.hpp"

#include <pthread.h>

namespace sinew::hal {
namespace {

class InheritingMutex final : public Mutex {
 public:
  explicit InheritingMutex(const pthread_mutexattr_t& attributes) { pthread_mutex_init(&mutex_, &attributes); }
  ~InheritingMutex() override { pthread_mutex_destroy(&mutex_); }
  InheritingMutex(const InheritingMutex&) = delete;
  InheritingMutex& operator=(const InheritingMutex&) = delete;
  void lock() noexcept override { pthread_mutex_lock(&mutex_); }
  void unlock() noexcept override { pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_;
};

}  // namespace

Result<std::unique_ptr<Mutex>> priority_mutex() {
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  const int refused = pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
  std::unique_ptr<Mutex> mutex;
  if (refused == 0) mutex = std::make_unique<InheritingMutex>(attributes);
  pthread_mutexattr_destroy(&attributes);
  if (refused != 0) return Error{Errc::not_supported, "a mutex that inherits priority", refused};
  return mutex;
}

}  // namespace sinew::hal
