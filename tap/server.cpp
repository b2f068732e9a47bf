#include "tap/server.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <new>
#include <span>
#include <vector>

#include "hal/linux/run_dir.hpp"
#include "hal/linux/socket.hpp"
#include "tap/answers.hpp"
#include "tap/connection.hpp"

namespace sinew::tap {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kSoon = 1ms;    // a client waits for a change
constexpr hal::Duration kLater = 20ms;  // a client is throttled or slow
constexpr hal::Duration kIdle = 1s;

}  // namespace

class Server::Body {
 public:
  Body(std::unique_ptr<Answering> answering, hal::Os& os, const ServerLimits& limits)
      : os_(os), limits_(limits), answering_(std::move(answering)) {}
  ~Body() {
    end_.store(true, std::memory_order_relaxed);
    if (wake_) static_cast<void>(wake_->write_now(std::as_bytes(std::span("x", 1))));
    thread_.reset();
  }

  hal::Status start(const Name& name) {
    const SharedTopics& topics = answering_->shared_topics();
    if (topics.memory) {
      rt::OutsideBells* bells = topics.bells;
      if (!bells) {
        auto own = rt::OutsideBells::make(os_, topics.segment.header().writer_count);
        if (!own) return own.error();
        own_bells_ = std::move(*own);
        bells = own_bells_.get();
      }
      auto notifier = TopicNotifier::open(topics.segment, *bells, os_);
      if (!notifier) return notifier.error();
      notifier_ = std::move(*notifier);
    }
    answering_->ring_with(notifier_.get());
    answering_->outsiders = [this] { return outsiders(); };
    auto listener = hal::listen_stream("unix:" + name.path());
    if (!listener) return listener.error();
    listener_ = std::move(*listener);
    auto ends = hal::stream_pair();
    if (!ends) return ends.error();
    wake_ = std::move(ends->first), woken_ = std::move(ends->second);
    auto thread =
        os_.start_thread({.name = "robot socket", .cpus = {}, .stack_bytes = 128 * 1024, .nice = 5}, [this] { run(); });
    if (!thread) return thread.error();
    thread_ = std::move(*thread);
    return {};
  }

  ServerStats stats;

 private:
  void run() {
    std::array<hal::Waiting, hal::kMaxWaiting> room;
    while (!end_.load(std::memory_order_relaxed)) {
      const std::span waiting = std::span(room).first(2 + clients_.size());
      waiting[0] = {woken_->handle()}, waiting[1] = {listener_->handle()};
      const hal::Time before = os_.now();
      for (std::size_t i = 0; i < clients_.size(); ++i) waiting[2 + i] = clients_[i]->waiting(before);
      if (!hal::wait_ready(waiting, patience())) os_.sleep_until(os_.now() + kLater);  // never a hot loop
      const hal::Time now = os_.now();
      answering_->follow();
      for (std::size_t i = 0; i < clients_.size(); ++i) try_to_serve(*clients_[i], waiting[2 + i], now);
      if (waiting[1].ready) try_to_accept(now);
      std::erase_if(clients_, [this](const auto& c) { return ended(*c); });
      client_count_.store(static_cast<std::uint32_t>(clients_.size()), std::memory_order_relaxed);
    }
    clients_.clear();
  }

  hal::Duration patience() const {
    hal::Duration least = kIdle;
    for (const auto& c : clients_) {
      if (c->waits_for_change()) least = std::min<hal::Duration>(least, kSoon);
      if (c->throttled()) least = std::min<hal::Duration>(least, kLater);
    }
    return clients_.empty() ? kIdle : std::min(least, limits_.patience / 4);
  }

  /// When memory runs out the client must go, and the robot must not.
  void try_to_serve(Connection& c, const hal::Waiting& waiting, hal::Time now) {
    try {
      serve(c, waiting, now);
    } catch (const std::bad_alloc&) {
      c.give_up();
    }
  }
  void try_to_accept(hal::Time now) {
    try {
      accept(now);
    } catch (const std::bad_alloc&) {
      stats.out_of_memory.add();
    }
  }

  void serve(Connection& c, const hal::Waiting& waiting, hal::Time now) {
    if (c.waits_for_change()) {
      if (auto reply = answering_->settle(c.change()))
        c.settle(*reply, now);
      else if (c.change_is_late(now))
        c.settle(answering_->still_waiting(c.change()), now);
    } else if (waiting.ready && waiting.room) {
      c.write();
    } else if (waiting.ready) {
      if (const auto request = c.read(now)) answer(c, *request, now);
    }
    c.look_at_time(now);
  }

  void answer(Connection& c, std::string_view request, hal::Time now) {
    stats.requests.add();
    const Reply reply = answering_->answer(request, c.id(), &c.stream());
    if (reply.garbage) stats.garbage.add();
    if (!c.reply(reply, room_for_reply(), now)) stats.refused_replies.add();
    if (c.throttled()) stats.throttled.add();
  }

  std::size_t room_for_reply() const {
    std::size_t held = 0;
    for (const auto& c : clients_)
      if (c->held() > kShortReplyBytes) held += c->held();
    return held < limits_.long_reply_bytes ? limits_.long_reply_bytes - held : 0;
  }

  void accept(hal::Time now) {
    auto stream = listener_->accept(hal::Duration{0});
    if (!stream) return;
    const auto peer = (*stream)->peer();
    if (!peer || (peer->user != hal::user_id() && peer->user != 0)) {
      stats.refused_peers.add();
      return;
    }
    const auto of_peer =
        std::count_if(clients_.begin(), clients_.end(), [&](const auto& c) { return c->pid() == peer->pid; });
    const bool full = clients_.size() >= std::min<std::size_t>(limits_.max_clients, hal::kMaxWaiting - 2);
    if (static_cast<std::uint32_t>(of_peer) >= limits_.max_per_process || (full && !make_room(now))) {
      stats.refused_full.add();
      return;
    }
    stats.accepted.add();
    clients_.push_back(std::make_unique<Connection>(++last_id_, std::move(*stream), peer->pid,
                                                    Allowance{limits_.requests_per_s, limits_.patience}, now));
  }

  /// Closes the connection that has asked nothing for the longest time. A connection that doorbells wake goes only when
  /// there is no other.
  bool make_room(hal::Time now) {
    const auto rank = [this](const auto& c) {
      return std::pair(notifier_ && notifier_->subscribes(c->id()), c->last_request());
    };
    const auto longest = std::min_element(clients_.begin(), clients_.end(),
                                          [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    if (longest == clients_.end() || now - (*longest)->last_request() < limits_.may_be_replaced_after) return false;
    answering_->forget((*longest)->id());
    clients_.erase(longest);
    stats.made_room.add();
    return true;
  }

  bool ended(const Connection& c) {
    using End = Connection::End;
    if (c.end() == End::open) return false;
    if (c.end() == End::garbage) stats.closed_for_garbage.add();
    if (c.end() == End::slow) stats.closed_slow.add();
    if (c.end() == End::out_of_memory) stats.out_of_memory.add();
    answering_->forget(c.id());
    return true;
  }

  Json outsiders() const {
    return {{"clients", client_count_.load(std::memory_order_relaxed)},
            {"accepted", stats.accepted.value()},
            {"requests", stats.requests.value()},
            {"refused_peers", stats.refused_peers.value()},
            {"refused_full", stats.refused_full.value()},
            {"made_room", stats.made_room.value()},
            {"garbage", stats.garbage.value()},
            {"closed_for_garbage", stats.closed_for_garbage.value()},
            {"closed_slow", stats.closed_slow.value()},
            {"throttled", stats.throttled.value()},
            {"refused_replies", stats.refused_replies.value()},
            {"out_of_memory", stats.out_of_memory.value()}};
  }

  hal::Os& os_;
  const ServerLimits limits_;
  std::unique_ptr<Answering> answering_;
  std::unique_ptr<rt::OutsideBells> own_bells_;  // null: those of what answers
  std::unique_ptr<TopicNotifier> notifier_;      // reads the segment of what answers
  std::unique_ptr<hal::Listener> listener_;
  std::unique_ptr<hal::Stream> wake_, woken_;  // the destructor ends the thread's wait
  std::vector<std::unique_ptr<Connection>> clients_;
  std::uint64_t last_id_ = 0;
  std::atomic<std::uint32_t> client_count_{0};
  std::atomic<bool> end_{false};
  std::unique_ptr<hal::Thread> thread_;
};

Server::Server(std::unique_ptr<Body> body) : body_(std::move(body)) {}
Server::~Server() = default;

hal::Result<std::unique_ptr<Server>> Server::open(const Name& name, rt::Graph& graph, rt::Runner& runner, hal::Os& os,
                                                  const ServerOptions& options) {
  auto answers = std::make_unique<Answers>(
      graph, runner, os,
      Answers::Robot{name.robot(), options.board, options.virtual_time, options.stop, options.robot_file, options.clock,
                     options.record_control, options.complaints});
  return open(name, std::move(answers), os, options.limits);
}

hal::Result<std::unique_ptr<Server>> Server::open(const Name& name, std::unique_ptr<Answering> answering, hal::Os& os,
                                                  const ServerLimits& limits) {
  auto body = std::make_unique<Body>(std::move(answering), os, limits);
  if (auto started = body->start(name); !started) return started.error();
  return std::unique_ptr<Server>(new Server(std::move(body)));
}

const ServerStats& Server::stats() const { return body_->stats; }

}  // namespace sinew::tap
