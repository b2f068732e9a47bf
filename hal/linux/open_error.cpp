#include "hal/linux/open_error.hpp"

#include <grp.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace sinew::hal {
namespace {

/// "group 'dialout'" where the file's group may open it, else the users that may.
std::string who_may(const std::string& path) {
  struct stat s {};
  if (::stat(path.c_str(), &s) != 0) return "a folder above it is closed to this user";
  std::array<char, 1024> space{};
  group entry{};
  group* found = nullptr;
  ::getgrgid_r(s.st_gid, &entry, space.data(), space.size(), &found);
  const std::string name = found ? found->gr_name : std::to_string(s.st_gid);
  if ((s.st_mode & 0060) == 0060 && s.st_gid != 0)
    return "group '" + name + "' may: sudo usermod -aG " + name + " USER, then log in again";
  return "only its owner may: give it to a group with a udev rule (GROUP=\"" + name + "\", MODE=\"0660\")";
}

// strerror_r() has two forms: GNU's answers a text that may lie elsewhere, POSIX's fills the given space.
[[maybe_unused]] std::string text_of(const char* answer, const char*) { return answer; }
[[maybe_unused]] std::string text_of(int, const char* space) { return space; }

}  // namespace

std::string errno_text(int why_errno) {
  std::array<char, 128> space{};
  return text_of(strerror_r(why_errno, space.data(), space.size()), space.data());
}

Error open_error(const std::string& path, int e, const OpenHint& hint, const char* where, std::string& why) {
  switch (e) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
    case ENOTDIR:
      why = path + ": there is no such device";
      if (!hint.absent.empty()) why += "; " + std::string(hint.absent);
      return {Errc::not_found, where, e};
    case EACCES:
    case EPERM:
      why = path + ": permission denied; " + who_may(path);
      return {Errc::denied, where, e};
    case EBUSY:
    case EWOULDBLOCK:
      why = path + ": somebody else holds it; find out who with: fuser -v " + path;
      return {Errc::busy, where, e};
    case ENOTTY:
    case EINVAL:
      why = path + ": is another kind of file (" + errno_text(e) + ")";
      return {Errc::not_supported, where, e};
    default:
      why = path + ": " + errno_text(e);
      return {Errc::io, where, e};
  }
}

}  // namespace sinew::hal
