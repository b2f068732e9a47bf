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

#include "monitor/json_reply.hpp"

namespace sinew::monitor {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "run.mcap";
constexpr std::string_view kPath = "/api/runs";
constexpr std::size_t kPiece = 256 << 10;
constexpr std::string_view kReplay = "replay", kCompare = "compare", kOpen = "open", kClose = "close", kStop = "stop";
constexpr std::string_view kWith = "with";  // the other run of a comparison

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

/// A name of a folder in the folder of runs: it leads nowhere else.
bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= 255 && text[0] != '.' && text.find('/') == std::string_view::npos &&
         text.find('\0') == std::string_view::npos;
}

std::string replay_of(const std::string& name) { return "replay of " + name; }
std::string comparison_of(const std::string& a, const std::string& b) { return "comparison of " + a + " with " + b; }

Json member(const Json& object, const char* part, const char* name) {
  const auto at = object.find(part);
  if (at == object.end() || !at->is_object()) return {};
  const auto value = at->find(name);
  return value == at->end() ? Json() : *value;
}

std::string text_in(const Json& object, const char* part, const char* name) {
  const Json value = member(object, part, name);
  return value.is_string() ? value.get<std::string>() : std::string();
}

}  // namespace

Runs::Runs(Robots& robots, Server& server, Gate& gate, std::string sinew, Options options)
    : server_(server),
      gate_(gate),
      sinew_(std::move(sinew)),
      options_(std::move(options)),
      recordings_(robots, server, {sinew_, options_.on_failure}),
      jobs_(server) {
  for (const std::string& file : options_.files) recordings_.open(fs::absolute(file).lexically_normal().string());
}

void Runs::stop() {
  stop_.store(true);
  recordings_.stop();
  jobs_.stop();
  worker_.reset();
}

std::string Runs::path_of(const std::string& name) const {
  return fs::absolute(fs::path(options_.folder) / name / kFile).lexically_normal().string();
}

Runs::Known Runs::describe(const std::string& path, Known known) const {
  const ProgramEnd end = run_program({sinew_, "bag", "info", "--json", path}, {}, stop_);
  const Json info = Json::parse(end.output, nullptr, false);
  if (!end.why.empty() || !info.is_object()) {
    known.verdict = "cannot be read";
    return known;
  }
  const auto duration = info.find("duration_s");
  if (duration != info.end() && duration->is_number()) known.duration_s = duration->get<double>();
  known.begin_unix_ns = std::strtoll(text_in(info, "run", "unix_ns").c_str(), nullptr, 10);
  known.robot = text_in(info, "run", "robot"), known.verdict = text_in(info, "result", "outcome");
  return known;
}

std::vector<Runs::Listed> Runs::look() {
  std::error_code bad;
  std::vector<std::pair<std::int64_t, std::string>> found;  // when written, name
  for (const auto& entry : fs::directory_iterator(options_.folder, bad)) {
    struct stat file {};
    if (entry.is_symlink(bad) || stat((entry.path() / kFile).c_str(), &file) != 0 || !S_ISREG(file.st_mode)) continue;
    if (std::string name = entry.path().filename().string(); is_name(name))
      found.emplace_back(file.st_mtim.tv_sec * 1'000'000'000LL + file.st_mtim.tv_nsec, std::move(name));
  }
  std::sort(found.rbegin(), found.rend());
  if (found.size() > kMostShown) found.resize(kMostShown);
  std::erase_if(known_, [&](const auto& known) {
    return std::none_of(found.begin(), found.end(), [&](const auto& f) { return f.second == known.first; });
  });
  std::vector<Listed> runs;
  for (const auto& [written, name] : found) {
    if (stop_.load()) break;
    const std::string path = path_of(name);
    const std::uint64_t bytes = fs::file_size(path, bad);
    Known& known = known_[name];
    if (known.written_ns != written || known.bytes != bytes)
      known = describe(path, {.written_ns = written, .bytes = bytes});
    runs.push_back({name, path, known});
  }
  return runs;
}

std::string Runs::list(const std::vector<Listed>& runs) const {
  Json all = Json::array();
  for (const auto& [name, path, known] : runs)
    all.push_back({{"name", name},
                   {"path", path},
                   {"bytes", known.bytes},
                   {"begin_unix_ns", known.begin_unix_ns},
                   {"duration_s", known.duration_s},
                   {"robot", known.robot},
                   {"verdict", known.verdict},
                   {"replay", to_string(jobs_.state(replay_of(name)))},
                   {"open", recordings_.is_open(path)}});
  const std::string busy = jobs_.running();
  return to_text({{"ok", true}, {"runs", std::move(all)}, {"busy", busy.empty() ? Json() : Json(busy)}});
}

bool Runs::answer(const Request& request, const Server::Reply& reply) {
  const std::string_view path = request.path;
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (path != kPath && !path.starts_with(std::string(kPath) + "/")) return false;
  if (!are_shown()) {
    reply(json_error(404, "not_found", "this monitor shows no recorded runs (--runs FOLDER)"));
  } else if (path == kPath && reads) {
    const auto found = [this, reply] {
      server_.post([this, reply, runs = look()] { reply(json_response(200, list(runs))); });
    };
    if (!worker_ || !worker_->post(found)) reply(json_error(409, "busy", "the folder of runs is being looked at"));
  } else {
    const std::string_view rest = path.substr(std::min(path.size(), kPath.size() + 1));
    const std::size_t slash = std::min(rest.find('/'), rest.size());
    const std::string name(rest.substr(0, slash));
    const std::string_view what = rest.substr(std::min(rest.size(), slash + 1));
    if (!is_name(name))
      reply(json_error(404, "not_found", "known are /api/runs and /api/runs/NAME/..."));
    else if (reads)
      look_at(request, name, what, reply);
    else
      change(request, name, what, reply);
  }
  return true;
}

void Runs::look_at(const Request& request, const std::string& name, std::string_view what,
                   const Server::Reply& reply) const {
  const std::string* const other = request.argument(kWith);
  if (what == kFile)
    send_file(name, reply);
  else if (what == kReplay)
    reply(json_response(200, jobs_.describe(replay_of(name))));
  else if (what == kCompare && other)
    reply(json_response(200, jobs_.describe(comparison_of(name, *other))));
  else
    reply(json_error(404, "not_found", "known are /api/runs/NAME/run.mcap, .../replay and .../compare?with=OTHER"));
}

void Runs::change(const Request& request, const std::string& name, std::string_view what, const Server::Reply& reply) {
  if (const auto refusal = gate_.refuses_command(request))
    return reply(json_error(refusal->status, "denied", refusal->why));
  Response refusal;
  const auto body = json_body(request, refusal);
  if (!body) return reply(std::move(refusal));
  const std::string path = path_of(name), other = text_of(*body, "with");
  std::error_code none;
  if (!fs::is_regular_file(path, none))
    return reply(json_error(404, "not_found", fmt::format("no run '{}' here", name)));
  if (what == kOpen) return recordings_.open(path, reply);
  if (what == kClose) {
    if (recordings_.close(path)) return reply(json_response(200, to_text({{"ok", true}})));
    return reply(json_error(404, "not_found", fmt::format("'{}' was not opened by this monitor", name)));
  }
  if (what == kReplay) return begin(replay_of(name), {sinew_, "replay", "--compare", "--json", path}, reply);
  if (what == kCompare) {
    if (!is_name(other) || !fs::is_regular_file(path_of(other), none))
      return reply(json_error(404, "not_found", fmt::format("with: no run '{}' here", other)));
    return begin(comparison_of(name, other), {sinew_, "bag", "compare", "--json", path, path_of(other)}, reply);
  }
  if (what == kStop) {
    const bool ends = jobs_.end(other.empty() ? replay_of(name) : comparison_of(name, other));
    return reply(ends ? json_response(200, to_text({{"ok", true}}))
                      : json_error(404, "not_found", "nothing of this runs"));
  }
  reply(json_error(404, "not_found", "a run takes replay, compare, stop, open and close"));
}

void Runs::begin(const std::string& job, std::vector<std::string> argv, const Server::Reply& reply) {
  if (!jobs_.begin(job, std::move(argv)))
    return reply(json_error(409, "busy", fmt::format("the {} runs: wait for it, or end it", jobs_.running())));
  reply(json_response(200, jobs_.describe(job)));
}

void Runs::send_file(const std::string& name, const Server::Reply& reply) const {
  const std::string path = path_of(name);
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
