#pragma once
// Runs a small program of several threads in every way that the C++20 memory model allows for release, acquire and
// relaxed 32-bit atomics, and stops at the first run in which the program complains or races.
//
// The model is operational. Each atomic word keeps its whole modification order; a load may read any write that is not
// older than what the thread already knows of that word; an acquire load that reads a release write (or a
// read-modify-write behind it) learns all that the writing thread knew. Read-modify-writes read the newest write, also
// compare-exchanges that fail (C++ would let those read stale values for ever; no machine does).
// Plain<> data is checked for happens-before with vector clocks. Not modelled: runs in which a load sees a store that
// only later program order makes (load buffering), so a relaxed store may not overtake an earlier load here; the
// programs therefore keep data in Plain<>, where a missing order is a race in any run. Only one thread may store to a
// word (asserted), all may read-modify-write it. Fences: a store after a release fence hands on all that its thread
// knew at the fence; an acquire fence learns what every load before it would have learned as an acquire.
//
// Two interleavings that lead to the same execution graph (who read from whom, in which modification order) are the
// same from there on; the second is cut off. Graphs are told apart by a 64-bit hash.
#include <ucontext.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

namespace sinew::model {

inline constexpr int kMaxThreads = 3, kMaxWords = 40;

struct Report {
  std::uint64_t executions = 0;  // runs started, cut-off ones included
  std::uint64_t complete = 0;    // distinct complete executions
  std::uint64_t states = 0;      // distinct partial executions
  bool bounded = false;          // stopped by the limit before everything was seen
  std::string failure;           // empty: none
  std::string trace;             // its run: thread, word, place read (?) or written (=) in the word's history
};

class Explorer {
 public:
  /// P: constructor makes the shared words; `static constexpr int threads`; run(thread); finish() after all threads.
  template <class P>
  static Report explore(std::uint64_t limit = UINT64_MAX) {
    Explorer& e = instance();
    e.report_ = {};
    e.visited_.clear();
    e.decisions_.clear();
    e.thread_count_ = P::threads;
    for (bool more = true; more && e.report_.failure.empty(); more = e.next_execution()) {
      if (e.report_.executions == limit) {
        e.report_.bounded = true;
        break;
      }
      ++e.report_.executions;
      e.begin();
      P program;
      e.body_ = [](void* p, int thread) { static_cast<P*>(p)->run(thread); };
      e.program_ = &program;
      e.run_all();
      if (e.finished_ == e.thread_count_ && e.report_.failure.empty()) {
        ++e.report_.complete;
        program.finish();
      }
    }
    e.report_.states = e.visited_.size();
    return e.report_;
  }

  static Explorer& instance() {
    static Explorer e;
    return e;
  }

  /// Called by programs; inside a thread it does not return.
  void fail(const char* what) {
    if (report_.failure.empty()) report_.failure = what;
    for (std::size_t i = 0; report_.trace.empty() && i < trace_.size(); ++i)
      report_.trace += (i ? " " : "") + trace_[i].text();
    if (current_ >= 0) stop();
  }

 private:
  friend class Word;
  friend void release_fence();
  friend void acquire_fence();
  template <class T>
  friend class Plain;
  using Clock = std::array<std::uint16_t, kMaxThreads>;
  using View = std::array<std::uint8_t, kMaxWords>;

  struct Write {
    std::uint32_t value;
    Clock clock;  // what an acquire learns
    View view;
  };
  struct Location {
    std::vector<Write> writes;
    int storer = -1;
  };
  struct Thread {
    ucontext_t context;
    std::unique_ptr<std::byte[]> stack = std::make_unique<std::byte[]>(kStack);
    Clock clock;
    View view;
    Write fenced, pending;  // of the last release fence; of all loads, for the next acquire fence
    std::uint32_t ops;
    bool finished;
  };
  struct Event {
    int thread, word;
    std::uint32_t read, written;  // places in the word's modification order
    std::string text() const {
      return "t" + std::to_string(thread) + ":w" + std::to_string(word) + (written ? "=" : "?") +
             std::to_string(written ? written : read);
    }
  };
  struct Decision {
    std::uint16_t chosen, count;
  };
  static constexpr std::size_t kStack = 64 * 1024;

  void begin() {
    trace_.clear();
    depth_ = 0, hash_ = 0, finished_ = 0, words_ = 0, current_ = -1;
    for (int t = 0; t < thread_count_; ++t) {
      threads_[t].clock.fill(0), threads_[t].view.fill(0);
      threads_[t].fenced = threads_[t].pending = {};
      threads_[t].clock[t] = 1;
      threads_[t].ops = 0, threads_[t].finished = false;
    }
  }

  static void entry(unsigned thread) {
    Explorer& e = instance();
    const int t = static_cast<int>(thread);
    e.body_(e.program_, t);
    e.threads_[t].finished = true;
    if (++e.finished_ == e.thread_count_) e.stop();
    e.schedule();
    std::abort();
  }

  /// Makes a stack for the thread and runs it up to its first operation, which changes nothing that others can see.
  void start(int thread) {
    ucontext_t& c = threads_[thread].context;
    getcontext(&c);
    c.uc_stack.ss_sp = threads_[thread].stack.get();
    c.uc_stack.ss_size = kStack;
    c.uc_link = nullptr;
    makecontext(&c, reinterpret_cast<void (*)()>(&Explorer::entry), 1, static_cast<unsigned>(thread));
    current_ = thread;
    swapcontext(&main_, &c);
  }

  void run_all() {
    starting_ = true;
    for (int t = 0; t < thread_count_; ++t) start(t);
    starting_ = false;
    const int first = pick();
    if (first >= 0) {
      current_ = first;
      swapcontext(&main_, &threads_[first].context);
    }
    current_ = -1;
  }

  void stop() {
    current_ = -1;
    setcontext(&main_);
    std::abort();
  }

  /// The thread to run next, or -1 when all that follows was seen before.
  int pick() {
    std::array<int, kMaxThreads> ready{};
    std::uint16_t n = 0;
    for (int t = 0; t < thread_count_; ++t)
      if (!threads_[t].finished) ready[n++] = t;
    if (depth_ == decisions_.size() && !visited_.insert(hash_).second) return -1;
    return ready[choose(n)];
  }

  std::uint16_t choose(std::uint16_t count) {
    if (depth_ == decisions_.size()) decisions_.push_back({0, count});
    return decisions_[depth_++].chosen;
  }

  bool next_execution() {
    while (!decisions_.empty() && decisions_.back().chosen + 1 == decisions_.back().count) decisions_.pop_back();
    if (decisions_.empty()) return false;
    ++decisions_.back().chosen;
    return true;
  }

  /// Before each operation on a word: another thread may go first.
  void schedule() {
    if (starting_) {
      swapcontext(&threads_[current_].context, &main_);
      return;  // chosen
    }
    const int from = current_, to = pick();
    if (to < 0) stop();
    if (to == from) return;
    current_ = to;
    if (threads_[from].finished)
      setcontext(&threads_[to].context);
    else
      swapcontext(&threads_[from].context, &threads_[to].context);
  }

  static constexpr std::uint64_t mix(std::uint64_t x) {
    x += 0x9E3779B97F4A7C15;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
    return x ^ (x >> 31);
  }

  /// Adds an event of the execution graph to its hash; the sum does not depend on the interleaving.
  void event(int word, std::size_t read, std::size_t written) {
    Thread& t = self();
    trace_.push_back({current_, word, static_cast<std::uint32_t>(read), static_cast<std::uint32_t>(written)});
    hash_ += mix(mix((std::uint64_t{t.ops++} << 32) | (static_cast<std::uint64_t>(current_) << 24) |
                     static_cast<std::uint64_t>(word)) +
                 (read << 20) + written);
    ++t.clock[current_];
  }

  Thread& self() { return threads_[current_]; }

  static bool acquires(std::memory_order o) { return o == std::memory_order_acquire || o == std::memory_order_acq_rel; }
  static bool releases(std::memory_order o) { return o == std::memory_order_release || o == std::memory_order_acq_rel; }

  void learn(const Write& w) {
    Thread& t = self();
    for (int i = 0; i < thread_count_; ++i) t.clock[i] = std::max(t.clock[i], w.clock[i]);
    for (int i = 0; i < words_; ++i) t.view[i] = std::max(t.view[i], w.view[i]);
  }

  /// A load learns at once, or leaves it to a later fence.
  void read(const Write& w, bool acquire) {
    if (acquire) learn(w);
    merge(self().pending, w);
  }
  void merge(Write& into, const Write& w) {
    for (int i = 0; i < thread_count_; ++i) into.clock[i] = std::max(into.clock[i], w.clock[i]);
    for (int i = 0; i < words_; ++i) into.view[i] = std::max(into.view[i], w.view[i]);
  }
  /// Fences are no events: they only change the meaning of later loads and stores.
  void fence(bool acquire) {
    if (current_ < 0) return;
    Thread& t = self();
    if (acquire)
      learn(t.pending);
    else
      t.fenced.clock = t.clock, t.fenced.view = t.view;
  }

  void append(int word, std::uint32_t value, bool release, const Write* read) {
    Location& l = locations_[word];
    Thread& t = self();
    t.view[word] = static_cast<std::uint8_t>(l.writes.size());
    Write w{value, {}, {}};
    if (release) w.clock = t.clock, w.view = t.view;
    merge(w, t.fenced);
    if (read) merge(w, *read);  // a read-modify-write carries on what it read: the release sequence
    w.view[word] = t.view[word];
    if (l.writes.size() == 255) fail("the program is too long for the model");
    l.writes.push_back(w);
  }

  Report report_;
  std::unordered_set<std::uint64_t> visited_;
  std::vector<Decision> decisions_;
  std::vector<Event> trace_;
  std::size_t depth_ = 0;
  bool starting_ = false;
  std::uint64_t hash_ = 0;
  int thread_count_ = 0, current_ = -1, finished_ = 0, words_ = 0;
  std::array<Thread, kMaxThreads> threads_;
  std::array<Location, kMaxWords> locations_;
  ucontext_t main_;
  void (*body_)(void*, int) = nullptr;
  void* program_ = nullptr;
};

inline void release_fence() { Explorer::instance().fence(false); }
inline void acquire_fence() { Explorer::instance().fence(true); }

inline void require(bool holds, const char* what) {
  if (!holds) Explorer::instance().fail(what);
}

/// Stands for std::atomic<std::uint32_t>. Made by the program's constructor, before the threads.
class Word {
 public:
  Word(std::uint32_t value = 0) : id_(explorer().words_++) {
    if (id_ >= kMaxWords) std::abort();
    auto& l = explorer().locations_[id_];
    l.writes.assign(1, {value, {}, {}});
    l.storer = -1;
  }
  Word(const Word&) = delete;

  std::uint32_t load(std::memory_order order) const {
    Explorer& e = explorer();
    if (e.current_ < 0) return peek();
    e.schedule();
    auto& writes = e.locations_[id_].writes;
    const std::size_t oldest = e.self().view[id_];
    const std::size_t at = writes.size() - 1 - e.choose(static_cast<std::uint16_t>(writes.size() - oldest));
    e.event(id_, at, 0);
    e.self().view[id_] = static_cast<std::uint8_t>(at);
    e.read(writes[at], Explorer::acquires(order));
    return writes[at].value;
  }
  void store(std::uint32_t value, std::memory_order order) {
    Explorer& e = explorer();
    if (e.current_ < 0) {
      e.locations_[id_].writes.back().value = value;
      return;
    }
    e.schedule();
    auto& l = e.locations_[id_];
    if (l.storer >= 0 && l.storer != e.current_) e.fail("the model knows no word with two storing threads");
    l.storer = e.current_;
    e.event(id_, 0, l.writes.size());
    clock_before(e, [&] { e.append(id_, value, Explorer::releases(order), nullptr); });
  }
  std::uint32_t fetch_add(std::uint32_t n, std::memory_order order) { return modify(n, order); }
  std::uint32_t fetch_sub(std::uint32_t n, std::memory_order order) { return modify(0 - n, order); }
  bool compare_exchange_strong(std::uint32_t& expected, std::uint32_t desired, std::memory_order success,
                               std::memory_order failure) {
    Explorer& e = explorer();
    e.schedule();
    auto& writes = e.locations_[id_].writes;
    const std::size_t at = writes.size() - 1;
    const bool ok = writes[at].value == expected;
    e.event(id_, at, ok ? at + 1 : 0);
    e.self().view[id_] = static_cast<std::uint8_t>(at);
    e.read(writes[at], Explorer::acquires(ok ? success : failure));
    if (ok) {
      const auto read = writes[at];
      clock_before(e, [&] { e.append(id_, desired, Explorer::releases(success), &read); });
    } else {
      expected = writes[at].value;
    }
    return ok;
  }
  /// The newest value, outside of threads.
  std::uint32_t peek() const { return explorer().locations_[id_].writes.back().value; }

 private:
  static Explorer& explorer() { return Explorer::instance(); }
  std::uint32_t modify(std::uint32_t n, std::memory_order order) {
    Explorer& e = explorer();
    e.schedule();
    const auto read = e.locations_[id_].writes.back();
    const std::size_t size = e.locations_[id_].writes.size();
    e.event(id_, size - 1, size);
    e.read(read, Explorer::acquires(order));
    clock_before(e, [&] { e.append(id_, read.value + n, Explorer::releases(order), &read); });
    return read.value;
  }
  /// A release hands on the thread's clock before this operation: later operations are not covered.
  template <class F>
  static void clock_before(Explorer& e, F&& append) {
    --e.self().clock[e.current_];
    append();
    ++e.self().clock[e.current_];
  }

  int id_;
};

/// Ordinary data; every unordered pair of accesses, one of them a write, is a failure.
template <class T>
class Plain {
 public:
  Plain(T value = {}) : value_(value) {}
  Plain(const Plain&) = delete;
  operator T() const {
    Explorer& e = Explorer::instance();
    if (e.current_ >= 0) {
      ordered(e, written_);
      read_[e.current_] = e.self().clock[e.current_];
    }
    return value_;
  }
  Plain& operator=(T value) {
    Explorer& e = Explorer::instance();
    if (e.current_ >= 0) {
      ordered(e, written_), ordered(e, read_);
      written_[e.current_] = e.self().clock[e.current_];
    }
    value_ = value;
    return *this;
  }

 private:
  static void ordered(Explorer& e, const Explorer::Clock& accesses) {
    for (int t = 0; t < e.thread_count_; ++t)
      if (accesses[t] > e.self().clock[t]) e.fail("data race");
  }
  T value_;
  mutable Explorer::Clock read_{};
  Explorer::Clock written_{};
};

}  // namespace sinew::model
