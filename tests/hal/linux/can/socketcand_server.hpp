#pragma once
// A socketcand server of one bus and one client at a time, on a port that the system chooses. Beside a test.
#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "wire/socketcand.hpp"

namespace sinew::hal {

class SocketcandServer {
 public:
  explicit SocketcandServer(std::string endpoint = "tcp:127.0.0.1:0") {
    auto listener = listen_stream(endpoint);
    if (!listener) return;
    listener_ = std::move(*listener);
    ThreadOptions options;
    options.name = "server";
    auto thread = system_os().start_thread(options, [this] { serve(); });
    if (thread) thread_ = std::move(*thread);
  }
  ~SocketcandServer() {
    stop_ = true;
    thread_.reset();
  }
  /// "127.0.0.1:PORT/can0"
  std::string address() const { return endpoint().substr(4) + "/can0"; }
  const std::string& endpoint() const { return listener_->endpoint(); }
  void tell(const msg::CanFrame& frame) {
    std::string text(wire::kSocketcandMax, ' ');
    text.resize(wire::socketcand_frame(frame, text));
    say(text);
  }
  /// Sends any text to the connected client; false: no client.
  bool say(const std::string& text) {
    const std::lock_guard lock(mutex_);
    return client_ && raw_ && client_->write(std::as_bytes(std::span(text)));
  }
  void hang_up() { hang_up_ = true; }
  bool connected() const { return raw_; }
  int connections() const { return connections_; }
  std::vector<msg::CanFrame> sent() {
    const std::lock_guard lock(mutex_);
    return sent_;
  }
  /// Only "can0" exists; other names are refused.
 private:
  void serve() {
    while (!stop_) {
      auto client = listener_->accept(std::chrono::milliseconds(20));
      if (!client) continue;
      {
        const std::lock_guard lock(mutex_);
        client_ = std::move(*client);
      }
      client_->set_patience(std::chrono::milliseconds(20));
      answer("< hi >");
      wire::SocketcandSplitter splitter;
      hang_up_ = false;
      while (!stop_ && !hang_up_) {
        std::array<char, 512> text{};
        const auto n = client_->read(std::as_writable_bytes(std::span(text)));
        if (!n && n.error().code != Errc::timeout) break;
        for (std::size_t i = 0; n && i < *n; ++i)
          if (splitter.push(text[i])) take(splitter.element());
      }
      const std::lock_guard lock(mutex_);
      raw_ = false;
      client_.reset();
    }
  }
  void answer(const std::string& text) {
    const std::lock_guard lock(mutex_);
    if (!client_->write(std::as_bytes(std::span(text)))) hang_up_ = true;
  }
  void take(std::string_view element) {
    wire::SocketcandMessage message;
    if (!wire::socketcand_parse(element, message)) return;
    if (message.kind == wire::SocketcandKind::open)
      answer(message.text == "can0" ? "< ok >" : "< error could not open bus >");
    if (message.kind == wire::SocketcandKind::raw_mode) {
      ++connections_;
      raw_ = true;  // before the client knows
      answer("< ok >");
    }
    if (message.kind == wire::SocketcandKind::send) {
      const std::lock_guard lock(mutex_);
      sent_.push_back(message.frame);
    }
  }

  std::unique_ptr<Listener> listener_;
  std::mutex mutex_;
  std::unique_ptr<Stream> client_;
  std::vector<msg::CanFrame> sent_;
  std::atomic<bool> stop_{false}, hang_up_{false}, raw_{false};
  std::atomic<int> connections_{0};
  std::unique_ptr<Thread> thread_;
};

}  // namespace sinew::hal
