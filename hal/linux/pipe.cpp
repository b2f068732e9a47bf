#include "hal/linux/pipe.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace sinew::hal {

bool Pipe::open() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return false;
  read = ends[0], write = ends[1];
  return true;
}

void Pipe::close(int& end) {
  if (end >= 0) ::close(end);
  end = -1;
}

Pipe::~Pipe() { close(read), close(write); }

}  // namespace sinew::hal
