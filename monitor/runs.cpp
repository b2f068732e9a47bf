#include "monitor/runs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "hal/linux/process.hpp"
#include "monitor/json_reply.hpp"

namespace sinew::monitor {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* kFile = "run.mcap";
constexpr std::string_view kPath = "/api/runs";
constexpr std::size_t kPiece = 256 << 10;
constexpr hal::Duration kPatience = 10s;  // for what is in one file

/// A file, piece by piece. Its length is that of the beginning: a file that grows is sent as it was.
class FileStream final : public Stream {
 public:
  FileStream(int fd, std::uint64_t bytes) : fd_(fd), left_(bytes) {}
  ~FileStream() override { close(fd_); }
  std::optional<Piece> next() override {
    auto piece = std::make_shared<std::vector<std::byte>>(std::min<std::uint64_t>(left_, kPiece));
    const ssize_t got = piece->empty() ? 0 : read(fd_, piece->data(), piece->size());
    if (got <= 0) {
      over_ = true;
      return std::nullopt;
    }
    piece->resize(static_cast<std::size_t>(got));
    left_ -= piece->size();
    return Piece{{}, std::move(piece), {}};
  }
  bool is_over() const override { return over_; }

 private:
  const int fd_;
  std::uint64_t left_;
  bool over_ = false;
};

/// What `sinew bag info --json` printed; null: nothing that can be used.
Json info_of(const std::string& sinew, const std::string& path) {
  auto child = hal::ChildProcess::start(std::vector<std::string>{sinew, "bag", "info", "--json", path},
                                        hal::ChildOptions{.piped = true, .own_group = true});
  if (!child) return {};
  std::string output, errors;
  hal::ChildProcess* const one[] = {child->get()};
  std::vector<std::size_t> ready;
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!(*child)->poll()) {
    hal::ChildProcess::wait_for_any(one, 200ms, ready);
    while ((*child)->read_output(output, errors)) {
    }
    if (std::chrono::steady_clock::now() > until) return {};  // it ends with the child's owner
  }
  while ((*child)->read_output(output, errors)) {
  }
  Json json = Json::parse(output, nullptr, false);
  return json.is_object() ? json : Json();
}

Json member(const Json& object, const char* part, const char* name) {
  const auto at = object.find(part);
  if (at == object.end() || !at->is_object()) return {};
  const auto value = at->find(name);
  return value == at->end() ? Json() : *value;
}

std::string text_of(const Json& json) { return json.is_string() ? json.get<std::string>() : std::string(); }

}  // namespace

std::string Runs::describe(const std::string& name, const std::string& path, std::uint64_t bytes) const {
  const Json info = info_of(options_.sinew, path);
  const std::string unix_ns = text_of(member(info, "run", "unix_ns"));
  const auto duration = info.is_object() ? info.find("duration_s") : info.end();
  return to_text(
      {{"name", name},
       {"bytes", bytes},
       {"begin_unix_ns", std::strtoll(unix_ns.c_str(), nullptr, 10)},
       {"duration_s", info.is_object() && duration != info.end() && duration->is_number() ? *duration : Json(0)},
       {"robot", text_of(member(info, "run", "robot"))},
       {"verdict", info.is_object() ? text_of(member(info, "result", "outcome")) : "cannot be read"}});
}

std::string Runs::list() {
  std::error_code bad;
  std::vector<std::pair<std::int64_t, std::string>> found;  // when written, name
  for (const auto& entry : fs::directory_iterator(options_.folder, bad)) {
    struct stat file {};
    if (entry.is_symlink(bad) || stat((entry.path() / kFile).c_str(), &file) != 0 || !S_ISREG(file.st_mode)) continue;
    found.emplace_back(file.st_mtim.tv_sec * 1'000'000'000LL + file.st_mtim.tv_nsec, entry.path().filename().string());
  }
  std::sort(found.rbegin(), found.rend());
  if (found.size() > kMostShown) found.resize(kMostShown);
  std::erase_if(known_, [&](const auto& known) {
    return std::none_of(found.begin(), found.end(), [&](const auto& f) { return f.second == known.first; });
  });
  std::string lines;
  for (const auto& [written, name] : found) {
    const std::string path = (fs::path(options_.folder) / name / kFile).string();
    const std::uint64_t bytes = fs::file_size(path, bad);
    Known& known = known_[name];
    if (known.line.empty() || known.written_ns != written || known.bytes != bytes)
      known = {written, bytes, describe(name, path, bytes)};
    lines += (lines.empty() ? "" : ", ") + known.line;
  }
  return R"({"ok": true, "runs": [)" + lines + "]}";
}

bool Runs::answer(const Request& request, const Server::Reply& reply) {
  const std::string_view path = request.path;
  if (path != kPath && !path.starts_with(std::string(kPath) + "/")) return false;
  if (!are_shown()) {
    reply(json_error(404, "not_found", "this monitor shows no recorded runs (--runs FOLDER)"));
  } else if (path == kPath) {
    if (!worker_.post([this, reply] { reply(json_response(200, list())); }))
      reply(json_error(409, "busy", "the folder of runs is being looked at"));
  } else {
    std::string_view rest = path.substr(kPath.size() + 1);
    const std::size_t slash = rest.find('/');
    if (slash == std::string_view::npos || rest.substr(slash + 1) != kFile)
      reply(json_error(404, "not_found", "known are /api/runs and /api/runs/NAME/run.mcap"));
    else
      send_file(std::string(rest.substr(0, slash)), reply);
  }
  return true;
}

void Runs::send_file(const std::string& name, const Server::Reply& reply) const {
  // The path is a plain one (is_plain_path): its parts lead to nothing outside of the folder.
  const std::string path = (fs::path(options_.folder) / name / kFile).string();
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  struct stat file {};
  if (fd < 0 || fstat(fd, &file) != 0 || !S_ISREG(file.st_mode)) {
    if (fd >= 0) close(fd);
    return reply(json_error(404, "not_found", fmt::format("no run '{}' here", name)));
  }
  const auto bytes = static_cast<std::uint64_t>(file.st_size);
  Response r;
  r.media_type = "application/octet-stream";
  r.headers = {{"content-disposition", "attachment"}, {"cache-control", "no-store"}};
  r.stream = std::make_unique<FileStream>(fd, bytes);
  r.stream_bytes = bytes;
  reply(std::move(r));
}

}  // namespace sinew::monitor
