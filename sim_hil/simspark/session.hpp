#pragma once
#include <deque>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "sim_hil/simspark/arena.hpp"
#include "wire/text/simspark.hpp"

namespace sinew::simspark {

/// What clients did, for the report.
struct DoorCounts {
  std::uint64_t connections = 0, agents = 0, monitors = 0;
  std::uint64_t refused = 0;  // clients without a player: team full, number taken, too many connections
  std::uint64_t closed = 0;   // clients that the server let go: their bytes were no message
  std::uint64_t messages = 0, sent = 0, unsent = 0;  // unsent: the client did not read
  std::uint64_t unknown = 0;                         // expressions that are none of an agent's or monitor's
  std::uint64_t early = 0;                           // motors, beams and words of clients that are no player yet
  std::uint64_t not_now = 0;                         // beams in a play mode that has none
  std::map<std::string, std::uint64_t> of_type{};    // unknown expressions, the first kMostTypes
  std::vector<std::string> news{};                   // a line for each player that came or went, the first kMostNews
  static constexpr std::size_t kMostTypes = 20, kMostNews = 256;

  void tell(std::string line);
  void add_unknown(std::string_view type);
};

/// One connection without its socket: frames of a client in, frames for it out.
/// Thread:  owner.   Errors: a frame that is too long or no S-expression closes the connection; why() says what it was.
class Connection {
 public:
  static constexpr std::size_t kMostFrame = 65536, kMostWaiting = std::size_t{256} * 1024;

  Connection(SparkArena& arena, DoorCounts& counts, std::string address);
  virtual ~Connection() = default;
  Connection(const Connection&) = delete;

  void receive(std::span<const std::byte> bytes);
  /// Waits to be sent; drop_sent() takes off what was.
  std::string_view waiting() const { return std::string_view(out_).substr(sent_); }
  void drop_sent(std::size_t bytes);
  /// Let go: nothing of it is heard any more.
  bool closed() const { return !why_.empty(); }
  const std::string& why() const { return why_; }
  void close(std::string why);

 protected:
  virtual void obey(std::string_view text) = 0;
  virtual std::string name() const = 0;
  void send(std::span<const char> frame);

  SparkArena& arena_;
  DoorCounts& counts_;
  std::string address_;

 private:
  std::vector<char> buffer_;
  wire::SparkFrames frames_;
  std::string out_, why_;
  std::size_t sent_ = 0;
};

/// An agent. "(scene)" is answered at once by percepts of nobody, "(init)" makes it a player, which feels each cycle
/// from then on. Its motors go on as they were last told while it is silent, as the original's do.
class AgentSession final : public Connection {
 public:
  using Connection::Connection;
  ~AgentSession() override;

  std::optional<std::size_t> player() const { return slot_; }
  /// Lockstep: nothing more has to come from it before the next cycle.
  bool synced() const { return closed() || !slot_ || synced_; }
  /// After a cycle: its percepts.
  void tell();

 private:
  void obey(std::string_view text) override;
  std::string name() const override;
  void init(const wire::SparkEffector& effector);

  std::optional<std::size_t> slot_{};
  bool scene_ = false, synced_ = false;
  wire::SparkPercepts percepts_{};
};

/// A monitor: it gets the state of the game each second cycle, and leads it as a trainer. The scene itself, bodies as
/// meshes, is not served.
class MonitorSession final : public Connection {
 public:
  using Connection::Connection;
  void tell();
  /// It asked for the end of the server.
  bool kills() const { return kills_; }
  /// The players whose clients it wants gone.
  std::vector<std::size_t> take_killed() { return std::exchange(killed_, {}); }

 private:
  void obey(std::string_view text) override;
  void obey(const wire::SparkOrder& order);
  std::string name() const override { return "monitor"; }

  bool told_ = false, kills_ = false;
  std::uint64_t cycles_ = 0;
  std::vector<std::size_t> killed_{};
};

}  // namespace sinew::simspark
