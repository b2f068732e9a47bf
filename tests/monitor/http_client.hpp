#pragma once
// A client that sends what a test says, also nonsense, and reads one response after the other.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sinew::monitor::test {

using namespace std::chrono_literals;

struct Reply {
  int status = 0;  // 0: the connection ended, or the patience
  std::map<std::string, std::string> headers{};
  std::string body{};
  bool closed = false;  // the peer ended the connection
};

class HttpClient {
 public:
  /// `from`: the address that we are, of 127.0.0.0/8; 0: any.
  explicit HttpClient(std::uint16_t port, std::uint32_t from = 0)
      : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), port_(port) {
    sockaddr_in to{};
    if (from != 0) {
      sockaddr_in own{};
      own.sin_family = AF_INET, own.sin_addr.s_addr = htonl(from);
      static_cast<void>(bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own));
    }
    to.sin_family = AF_INET, to.sin_port = htons(port), to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }
  ~HttpClient() { close(fd_); }
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  bool connected() const { return connected_; }
  int fd() const { return fd_; }
  bool send(std::string_view text) {
    while (!text.empty()) {
      const ssize_t n = ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }

  /// `more`: further lines of the head, each with its line end.
  Reply ask(const std::string& method, const std::string& path, const std::string& more = "",
            const std::string& body = "") {
    std::string head = method + " " + path + " HTTP/1.1\r\nHost: " + host() + "\r\n" + more;
    if (!body.empty()) head += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    send(head + "\r\n" + body);
    return reply(method == "HEAD");
  }
  Reply get(const std::string& path, const std::string& more = "") { return ask("GET", path, more); }
  Reply post(const std::string& path, const std::string& body, const std::string& more) {
    return ask("POST", path, "Content-Type: application/json\r\n" + more, body);
  }

  /// The next response, or what came of it within the patience.
  Reply reply(bool head_only = false, std::chrono::milliseconds patience = 10s) {
    const auto until = std::chrono::steady_clock::now() + patience;
    Reply r;
    std::size_t end = std::string::npos;
    while ((end = held_.find("\r\n\r\n")) == std::string::npos)
      if (!more(until, r.closed)) return r;
    std::string_view head(held_.data(), end);
    r.status = std::atoi(std::string(head.substr(9, 3)).c_str());
    while (!head.empty()) {
      const std::size_t line = head.find("\r\n");
      const std::string_view one = head.substr(0, line);
      if (const std::size_t colon = one.find(": "); colon != std::string_view::npos) {
        std::string name(one.substr(0, colon));
        std::transform(name.begin(), name.end(), name.begin(),
                       [](char c) { return static_cast<char>(std::tolower(c)); });
        r.headers[name] = one.substr(colon + 2);
      }
      head = line == std::string_view::npos ? std::string_view() : head.substr(line + 2);
    }
    held_.erase(0, end + 4);
    const auto length = r.headers.find("content-length");
    if (head_only || r.status == 304 || length == r.headers.end()) return r;
    const std::size_t bytes = std::strtoul(length->second.c_str(), nullptr, 10);
    while (held_.size() < bytes)
      if (!more(until, r.closed)) return r;
    r.body = held_.substr(0, bytes);
    held_.erase(0, bytes);
    return r;
  }
  /// Reads until `text` has come; false: the peer ended before, or the patience.
  bool wait_for(std::string_view text, std::chrono::milliseconds patience = 10s) {
    const auto until = std::chrono::steady_clock::now() + patience;
    bool closed = false;
    std::size_t at = 0;
    while ((at = held_.find(text)) == std::string::npos)
      if (!more(until, closed)) return false;
    held_.erase(0, at + text.size());
    return true;
  }
  /// The next bytes as they are; fewer: the peer ended before, or the patience.
  std::string take(std::size_t bytes, std::chrono::milliseconds patience = 10s) {
    const auto until = std::chrono::steady_clock::now() + patience;
    bool closed = false;
    while (held_.size() < bytes && more(until, closed)) {
    }
    std::string taken = held_.substr(0, bytes);
    held_.erase(0, taken.size());
    return taken;
  }
  /// The peer ends the connection, whatever it sends before.
  bool is_ended(std::chrono::milliseconds patience = 10s) {
    const auto until = std::chrono::steady_clock::now() + patience;
    bool closed = false;
    while (more(until, closed)) held_.clear();
    return closed;
  }

 private:
  bool more(std::chrono::steady_clock::time_point until, bool& closed) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    pollfd wait{fd_, POLLIN, 0};
    if (left <= 0ms || poll(&wait, 1, static_cast<int>(left.count())) != 1) return false;
    char bytes[65536];
    const ssize_t n = recv(fd_, bytes, sizeof bytes, 0);
    closed = n <= 0;
    if (n > 0) held_.append(bytes, static_cast<std::size_t>(n));
    return n > 0;
  }

  int fd_;
  std::uint16_t port_;
  bool connected_ = false;
  std::string held_{};
};

}  // namespace sinew::monitor::test
