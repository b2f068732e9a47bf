#include "sim_hil/usarsim/server.hpp"

#include <algorithm>
#include <array>

namespace sinew::usarsim {

using hal::Duration;
using hal::Time;

Server::Server(hal::Os& os, Game& game, Doors doors, Painter* painter)
    : os_(os), game_(game), doors_(std::move(doors)) {
  if (painter) pictures_ = std::make_unique<PictureMaker>(game, *painter);
}

template <class S, class Make>
void Server::welcome(hal::Listener& listener, std::vector<Client<S>>& clients, std::size_t most, Make&& make) {
  while (auto stream = listener.accept(Duration{0})) {
    if (clients.size() == most) {
      ++game_.counts().refused;
      continue;  // closes it
    }
    const std::string address = doors_.address(**stream);
    clients.push_back({std::move(*stream), make(address)});
  }
}

template <class S>
void Server::hear(Client<S>& client) {
  std::array<std::byte, 16384> buffer;
  constexpr int kMostReads = 4;  // of one client in a tick
  for (int i = 0; i < kMostReads; ++i) {
    const auto n = client.stream->read_now(buffer);
    client.gone = client.gone || !n;
    if (!n || *n == 0) return;
    client.session->receive({buffer.data(), *n});
  }
}

template <class S>
void Server::tell(Client<S>& client) {
  while (!client.gone && !client.session->waiting().empty()) {
    const std::string_view text = client.session->waiting();
    const auto n = client.stream->write_now(std::as_bytes(std::span(text.data(), text.size())));
    client.gone = !n;
    if (!n || *n == 0) return;
    client.session->drop_sent(*n);
  }
}

void Server::serve_pictures() {
  if (!pictures_) return;
  if (const Picture* picture = pictures_->poll(); picture && shown_) {
    shown_->answer(*picture);
    shown_ = nullptr;
  }
  for (std::size_t i = 0; i < image_clients_.size() && pictures_->free(); ++i) {
    Client<ImageSession>& client = image_clients_[(turn_ + i) % image_clients_.size()];
    if (client.gone || !client.session->wanted()) continue;
    shown_ = client.session.get();
    pictures_->begin(shown_->wall());
    turn_ = (turn_ + i + 1) % image_clients_.size();
  }
}

void Server::tick() {
  welcome(*doors_.text, clients_, kMostClients,
          [&](const std::string& address) { return std::make_unique<Session>(game_, address, ++number_); });
  if (doors_.images)
    welcome(*doors_.images, image_clients_, kMostImageClients,
            [&](const std::string& address) { return std::make_unique<ImageSession>(game_, address); });
  for (auto& client : clients_) hear(client);
  for (auto& client : image_clients_) hear(client);
  for (std::int64_t ns = 0; ns < kTick.count(); ns += plant::kStepNs) game_.place().advance({});
  for (auto& client : clients_) client.session->tick();
  serve_pictures();
  for (auto& client : clients_) tell(client);
  for (auto& client : image_clients_) tell(client);
  std::erase_if(clients_, [](const auto& c) { return c.gone; });
  std::erase_if(image_clients_, [&](const auto& c) {
    if (c.gone && shown_ == c.session.get()) shown_ = nullptr;  // its picture is finished for nobody
    return c.gone;
  });
}

std::uint64_t Server::run(double duration_s, const std::function<bool()>& stop) {
  std::uint64_t late = 0;
  Time due = os_.now() + kTick;
  while (!stop() && (duration_s <= 0 || game_.now_s() < duration_s)) {
    os_.sleep_until(due);
    tick();
    due = due + kTick;
    if (os_.now() - due > kMostLateTicks * kTick) ++late, due = os_.now() + kTick;
  }
  // A picture that is being drawn goes to memory of this server.
  while (pictures_ && !pictures_->free()) static_cast<void>(pictures_->poll()), os_.sleep_until(os_.now() + kTick);
  return late;
}

}  // namespace sinew::usarsim
