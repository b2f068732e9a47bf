#include "monitor/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

namespace sinew::monitor {
namespace {

constexpr std::string_view kPanels = "/panels/";
constexpr std::string_view kPanelEnding = ".js";
// What a panel may bring along; other files of the folder are nobody's business.
constexpr std::pair<std::string_view, std::string_view> kPanelTypes[] = {
    {kPanelEnding, "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"}};

Bytes copy_of(std::span<const std::byte> bytes) {
  return std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
}

bool takes_gzip(const Request& request) { return request.accept_encoding.find("gzip") != std::string::npos; }

}  // namespace

Page::Page(std::string panels) : panels_folder_(std::move(panels)) {
  for (const PageFile& f : page_files())
    files_.emplace(f.path, File{f.media_type, f.etag, copy_of(f.bytes), copy_of(f.gzip)});
}

bool Page::answer(const Request& request, const Server::Reply& reply) const {
  const std::string_view path = request.path;
  if (path.starts_with(kPanels)) {
    panel(path.substr(kPanels.size()), reply);
    return true;
  }
  const auto found = files_.find(path == "/" ? "/index.html" : path);
  if (found == files_.end()) return false;
  const File& file = found->second;
  Response r;
  r.media_type = file.media_type;
  // The browser asks each time whether it is still the same: a monitor of another version has the same address.
  r.headers = {{"cache-control", "no-cache"}, {"etag", std::string(file.etag)}, {"vary", "accept-encoding"}};
  if (request.if_none_match == file.etag) {
    r.status = 304;
  } else if (takes_gzip(request)) {
    r.headers.emplace_back("content-encoding", "gzip");
    r.body = file.gzip;
  } else {
    r.body = file.bytes;
  }
  reply(std::move(r));
  return true;
}

void Page::panel(std::string_view name, const Server::Reply& reply) const {
  if (panels_folder_.empty()) return reply(plain(404, "this monitor was started without --panels FOLDER"));
  const auto type = std::find_if(std::begin(kPanelTypes), std::end(kPanelTypes),
                                 [&](const auto& known) { return name.ends_with(known.first); });
  const bool is_hidden = name.starts_with('.') || name.find('/') != std::string_view::npos;
  if (type == std::end(kPanelTypes) || is_hidden)
    return reply(plain(404, fmt::format("'{}': a panel's files are .js, .css, .json, .svg and .png", name)));
  const std::filesystem::path file = std::filesystem::path(panels_folder_) / name;
  std::error_code none;
  const auto size = std::filesystem::file_size(file, none);
  if (none || !std::filesystem::is_regular_file(file, none))
    return reply(plain(404, fmt::format("'{}' is not in the folder of panels", name)));
  if (size > kMostPanelBytes)
    return reply(plain(413, fmt::format("'{}' is larger than {} bytes", name, kMostPanelBytes)));
  std::vector<char> text(static_cast<std::size_t>(size));
  std::ifstream in(file, std::ios::binary);
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size())))
    return reply(plain(500, fmt::format("'{}' cannot be read", name)));
  Response r;
  r.media_type = type->second;
  r.headers = {{"cache-control", "no-store"}};
  r.body = bytes_of({text.data(), text.size()});
  reply(std::move(r));
}

std::vector<std::string> Page::panels() const {
  std::vector<std::string> found;
  std::error_code error;
  if (panels_folder_.empty()) return found;
  for (const auto& entry : std::filesystem::directory_iterator(panels_folder_, error)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(kPanelEnding) && !name.starts_with('.')) found.push_back(std::string(kPanels) + name);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace sinew::monitor
