#include "hal/result.hpp"

namespace sinew::hal {

const char* to_string(Errc code) {
  switch (code) {
    case Errc::not_found:
      return "not found";
    case Errc::busy:
      return "busy";
    case Errc::denied:
      return "permission denied";
    case Errc::not_supported:
      return "not supported";
    case Errc::bad_argument:
      return "bad argument";
    case Errc::bad_data:
      return "bad data";
    case Errc::closed:
      return "closed";
    case Errc::timeout:
      return "timed out";
    case Errc::out_of_memory:
      return "out of memory";
    case Errc::io:
      return "input/output error";
  }
  return "unknown error";
}

}  // namespace sinew::hal
