#include "sim_hil/wire/socketcand_server.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace sinew::sim_hil {
namespace {

using namespace std::chrono_literals;
using wire::SocketcandKind;

constexpr hal::Duration kIdle = 20ms, kLook = 1ms;
constexpr int kFramesPerLook = 256;
constexpr int kReadsPerLook = 16;  // of a client; faster input waits in its socket

/// A port for an owner outside; the bus keeps the real one.
class Port final : public hal::CanBus {
 public:
  explicit Port(MemoryCanPort& port) : port_(port) {}
  hal::Result<bool> read(msg::CanFrame& out) noexcept override { return port_.read(out); }
  hal::Status send(const msg::CanFrame& frame, hal::Time deadline) noexcept override {
    return port_.send(frame, deadline);
  }
  hal::Status set_filters(std::span<const hal::CanFilter> filters) override { return port_.set_filters(filters); }
  void set_wake(hal::Wake* wake) noexcept override { port_.set_wake(wake); }
  hal::CanStats stats() const noexcept override { return port_.stats(); }
  std::uint32_t bit_rate() const noexcept override { return port_.bit_rate(); }

 private:
  MemoryCanPort& port_;
};

}  // namespace

hal::Result<std::unique_ptr<SocketcandServer>> SocketcandServer::open(hal::Os& os,
                                                                      std::unique_ptr<hal::Listener> listener,
                                                                      const std::vector<std::string>& buses) {
  std::unique_ptr<SocketcandServer> server(new SocketcandServer(os, std::move(listener)));
  for (const std::string& name : buses) server->buses_.push_back(std::make_unique<Bus>(name, os));
  hal::ThreadOptions options;
  options.name = "socketcand";
  auto thread = os.start_thread(options, [s = server.get()] { s->run(); });
  if (!thread) return thread.error();
  server->thread_ = std::move(*thread);
  return server;
}

SocketcandServer::~SocketcandServer() {
  stop_.store(true, std::memory_order_relaxed);  // join() synchronises
  thread_.reset();
}

hal::Result<std::unique_ptr<hal::CanBus>> SocketcandServer::bus(std::string_view name) {
  const auto bus = std::find_if(buses_.begin(), buses_.end(), [&](const auto& b) { return b->name == name; });
  if (bus == buses_.end()) return hal::Error{hal::Errc::not_found, "no bus of this name"};
  return std::unique_ptr<hal::CanBus>(std::make_unique<Port>((*bus)->wire.attach()));
}

SocketcandServerStats SocketcandServer::stats() const noexcept {
  return {came_.value(), refused_.value(), hung_up_.value(), malformed_.value(), lost_.value()};
}

void SocketcandServer::run() {
  bool more =
      false;  // frames that wait still: so many at a time, else a bus that is never silent would starve all clients
  while (!stop_.load(std::memory_order_relaxed)) {
    const auto wait = more ? hal::Duration{0} : clients_.empty() ? kIdle : kLook;
    if (auto caller = listener_->accept(wait)) admit(std::move(*caller));
    more = false;
    msg::CanFrame frame;
    for (const auto& bus : buses_) {
      int n = 0;
      for (; n < kFramesPerLook; ++n) {
        const auto got = bus->port.read(frame);
        if (!got || !*got) break;
        pass_on(*bus, frame, nullptr);
      }
      more = more || n == kFramesPerLook;
    }
    for (const auto& client : clients_) serve(*client, os_.now());
    std::erase_if(clients_, [](const auto& client) { return client->leaves; });
  }
}

void SocketcandServer::admit(std::unique_ptr<hal::Stream> stream) {
  if (clients_.size() == kMostClients) return refused_.add();  // and it is closed
  came_.add();
  auto client = std::make_unique<Client>();
  client->stream = std::move(stream);
  client->since = client->took = os_.now();
  say(*client, "< hi >");
  clients_.push_back(std::move(client));
}

void SocketcandServer::hang_up(Client& client) {
  client.leaves = true;
  hung_up_.add();
}

void SocketcandServer::nonsense(Client& client, std::uint64_t n) {
  malformed_.add(static_cast<std::uint32_t>(n));
  client.nonsense += n;
  if (client.nonsense > kMostNonsense && !client.leaves) hang_up(client);
}

void SocketcandServer::say(Client& client, std::string_view text) {
  if (client.waiting.size() + text.size() > kMostWaiting) return lost_.add();  // the client asks, but does not read
  client.waiting += text;
}

void SocketcandServer::serve(Client& client, hal::Time now) {
  std::array<char, 4096> text{};
  for (int i = 0; i < kReadsPerLook && !client.leaves; ++i) {
    const auto n = client.stream->read_now(std::as_writable_bytes(std::span(text)));
    if (!n) {
      client.leaves = true;  // it hung up
      return;
    }
    if (*n == 0) break;
    for (std::size_t c = 0; c < *n && !client.leaves; ++c)
      if (client.splitter.push(text[c])) take(client, client.splitter.element(), now);
    if (const auto dropped = client.splitter.dropped(); dropped != client.dropped) {
      nonsense(client, dropped - client.dropped);
      client.dropped = dropped;
    }
  }
  if (!client.raw && now - client.since > kGreeting && !client.leaves) return hang_up(client);
  if (!client.held.empty() && now >= client.frames_from) client.waiting += std::exchange(client.held, {});
  if (client.waiting.empty()) {
    client.took = now;
    return;
  }
  const auto n = client.stream->write_now(std::as_bytes(std::span(client.waiting)));
  if (!n) {
    client.leaves = true;
    return;
  }
  client.waiting.erase(0, *n);
  if (*n > 0) client.took = now;
  if (now - client.took > kStalled && !client.leaves) hang_up(client);
}

void SocketcandServer::take(Client& client, std::string_view element, hal::Time now) {
  wire::SocketcandMessage message;
  if (!wire::socketcand_parse(element, message)) {
    say(client, "< error unknown command >");
    return nonsense(client);
  }
  switch (message.kind) {
    case SocketcandKind::open: {
      const auto bus =
          std::find_if(buses_.begin(), buses_.end(), [&](const auto& b) { return b->name == message.text; });
      if (bus == buses_.end()) return say(client, "< error could not open bus >");
      client.bus = bus->get();
      return say(client, "< ok >");
    }
    case SocketcandKind::raw_mode:
      if (client.bus == nullptr) return say(client, "< error no bus is open >");
      if (!client.raw) client.frames_from = now + kAfterOk;
      client.raw = true;
      return say(client, "< ok >");
    case SocketcandKind::echo:
      return say(client, "< echo >");
    case SocketcandKind::send:
      if (!client.raw) return say(client, "< error not in raw mode >");
      static_cast<void>(client.bus->port.send(message.frame, hal::kNever));  // a bus in memory takes it
      message.frame.stamp = now;
      return pass_on(*client.bus, message.frame, &client);
    default:  // elements that only a server sends
      say(client, "< error unknown command >");
      return nonsense(client);
  }
}

void SocketcandServer::pass_on(Bus& bus, const msg::CanFrame& frame, const Client* from) {
  std::array<char, wire::kSocketcandMax> text{};
  const std::size_t size = wire::socketcand_frame(frame, text);
  if (size == 0) return lost_.add();
  const hal::Time now = os_.now();
  for (const auto& client : clients_) {
    if (client.get() == from || client->bus != &bus || !client->raw) continue;
    const bool early = now < client->frames_from || !client->held.empty();
    std::string& queue = early ? client->held : client->waiting;
    if (queue.size() + size + 1 > kMostWaiting) {
      lost_.add();
      continue;
    }
    queue += ' ';
    queue.append(text.data(), size);
  }
}

}  // namespace sinew::sim_hil
