#include "sim_hil/usarsim/server.hpp"

namespace sinew::usarsim {

using hal::Duration;
using hal::Time;

Server::Server(hal::Os& os, Game& game, Doors doors, Painter* painter)
    : os_(os), game_(game), doors_(std::move(doors)) {
  if (painter) pictures_ = std::make_unique<PictureMaker>(game, *painter);
}

void Server::serve_pictures() {
  if (!pictures_) return;
  if (const Picture* picture = pictures_->poll(); picture && shown_) {
    shown_->answer(*picture);
    shown_ = nullptr;
  }
  for (std::size_t i = 0; i < image_clients_.size() && pictures_->free(); ++i) {
    auto& client = image_clients_[(turn_ + i) % image_clients_.size()];
    if (client.gone || !client.session->wanted()) continue;
    shown_ = client.session.get();
    pictures_->begin(shown_->wall());
    turn_ = (turn_ + i + 1) % image_clients_.size();
  }
}

void Server::tick() {
  game_.counts().refused += sim_hil::welcome(*doors_.text, clients_, kMostClients, [&](const hal::Stream& stream) {
    return std::make_unique<Session>(game_, doors_.address(stream), ++number_);
  });
  if (doors_.images)
    game_.counts().refused += sim_hil::welcome(
        *doors_.images, image_clients_, kMostImageClients,
        [&](const hal::Stream& stream) { return std::make_unique<ImageSession>(game_, doors_.address(stream)); });
  for (auto& client : clients_) hear(client);
  for (auto& client : image_clients_) hear(client);
  for (std::int64_t ns = 0; ns < kTick.count(); ns += plant::kStepNs) game_.place().advance({});
  for (auto& client : clients_) client.session->tick();
  serve_pictures();
  for (auto& client : clients_) tell(client);
  for (auto& client : image_clients_) tell(client);
  std::erase_if(clients_, [](const auto& client) { return client.over(); });
  std::erase_if(image_clients_, [&](const auto& client) {
    if (client.over() && shown_ == client.session.get()) shown_ = nullptr;  // its picture is finished for nobody
    return client.over();
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
