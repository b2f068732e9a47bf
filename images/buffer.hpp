#pragma once
#include <cstddef>
#include <memory>
#include <new>

namespace sinew::images {

/// Memory that grows when it must and is never cleared.
template <class T>
class Buffer {
 public:
  /// Null: no memory. The content is unspecified after growing.
  T* at_least(std::size_t count) {
    if (count <= size_) return data_.get();
    data_.reset();  // first, so that both are never there together
    size_ = 0;
    data_.reset(new (std::nothrow) T[count]);
    if (data_) size_ = count;
    return data_.get();
  }
  T* get() const { return data_.get(); }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_ = 0;
};

}  // namespace sinew::images
