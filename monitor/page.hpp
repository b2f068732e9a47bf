#pragma once
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "monitor/http/server.hpp"

namespace sinew::monitor {

/// A file of the built page (monitor/web/dist) as it is in the program.
struct PageFile {
  std::string_view path;        // "/assets/page.js"
  std::string_view media_type;  // of its content
  std::string_view etag;        // quoted
  std::span<const std::byte> bytes, gzip;
};
/// Made by the build (cmake/page.cmake).
std::span<const PageFile> page_files();

/// The page, and panels of one's own below /panels/ from a folder, which are read anew for each request.
/// Thread:  the server's.
class Page {
 public:
  /// `panels`: a folder; empty: none. Errors: nothing can be found in a folder that is none.
  explicit Page(std::string panels = {});

  /// False: the path is none of the page, and `reply` was not used.
  bool answer(const Request& request, const Server::Reply& reply) const;
  /// Paths of the panels that the folder has now: "/panels/battery.js", in order of name.
  std::vector<std::string> panels() const;

  static constexpr std::size_t kMostPanelBytes = 4 << 20;

 private:
  struct File {
    std::string_view media_type, etag;
    Bytes bytes, gzip;
  };
  void panel(std::string_view name, const Server::Reply& reply) const;

  const std::string panels_folder_;
  std::map<std::string, File, std::less<>> files_;  // by path
};

}  // namespace sinew::monitor
