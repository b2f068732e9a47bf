#pragma once
#include <memory>
#include <string>
#include <vector>

#include "grab/grab_memory.hpp"
#include "hal/clock.hpp"
#include "hal/linux/grab/grab_titles.hpp"
#include "hal/linux/run_dir.hpp"

namespace sinew::hal {

/// Letters, digits, _, ., + and -, at most 40, not beginning with a dot.
bool is_grab_name(std::string_view name);

/// Where the session `name` listens: NAME.grab in the folder of running robots.
/// Errors:  bad_argument: the name; those of run_dir(). `why` has it in words.
Result<std::string> grab_socket_path(const std::string& name, std::string& why);

/// Names of all sessions of this user that run now.
std::vector<std::string> grab_sessions();

/// What `sinew grab` has: the memory that its programs and their readers share, and the socket where they get it. When
/// a program ends, its windows are freed; when a reader ends, its view is, with the memory of its pictures.
/// Thread:  owner.   RT: no.
class GrabSession {
 public:
  /// Errors:  bad_argument, busy (a session of this name runs), denied, io. `why` has it in words.
  static Result<std::unique_ptr<GrabSession>> open(const std::string& name, std::string& why);
  ~GrabSession();
  GrabSession(const GrabSession&) = delete;
  GrabSession& operator=(const GrabSession&) = delete;

  /// Serves whoever comes and goes, at most `patience`. Errors: io: the socket is broken.
  Status serve(Duration patience);

  const std::string& path() const { return path_; }
  /// Programs that are connected now, and those that ever were.
  std::size_t programs() const;
  std::size_t programs_seen() const { return programs_seen_; }
  std::size_t readers() const;
  const grab::Head& head() const { return *head_; }

 private:
  struct Peer {
    int fd = -1;
    std::uint32_t number = 0;
    grab::Hello::Role role = grab::Hello::Role::watcher;
    std::uint32_t view = grab::kNoNumber;
    bool welcome = false;
  };
  GrabSession() = default;
  void accept_one();
  bool introduced(Peer& peer);  // false: it goes
  void gone(const Peer& peer);
  void free_windows(std::uint32_t process);
  bool free_view(std::uint32_t view);
  void free_left_views();

  std::string path_;
  std::unique_ptr<FileLock> lock_;
  int listener_ = -1, memory_ = -1;
  grab::Head* head_ = nullptr;
  std::uint32_t next_number_ = 1;
  std::size_t programs_seen_ = 0;
  std::vector<Peer> peers_;
  std::unique_ptr<GrabTitles> titles_;  // from the first program on
  std::vector<std::uint32_t> left_;     // views whose reader is gone while a program is writing a picture
};

}  // namespace sinew::hal
