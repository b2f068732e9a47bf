#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace sinew::vision {

/// A stretch of pixels of one colour in one row.
struct Run {
  std::uint16_t y = 0;
  std::uint16_t x0 = 0, x1 = 0;  // x1 is one past the end
  std::uint16_t reserved = 0;
  std::uint32_t label = 0;  // while joining: an earlier run of the same region (or itself); afterwards: its region
};

/// A connected region (8 neighbours) of one colour.
struct Blob {
  std::uint32_t colour = 0;  // 1..kMaxColours
  std::uint32_t area_px = 0;
  std::uint16_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // bounding box, both ends included
  std::uint32_t region = 0;                      // label of its runs within its colour
  std::uint32_t runs = 0;
  std::int64_t sum_x = 0, sum_y = 0;
  double centre_x() const { return static_cast<double>(sum_x) / area_px; }
  double centre_y() const { return static_cast<double>(sum_y) / area_px; }
};

/// Joins the runs of one colour, row by row, by union-find. Memory is fixed at the start: runs beyond the capacity are
/// dropped and counted, so the time for an image of noise is bounded.
/// Thread:  owner.   RT: yes, except set_capacity (configure only).
class RunJoiner {
 public:
  void set_capacity(std::uint32_t max_runs) {
    runs_.assign(max_runs, {});
    clear();
  }
  void clear() { count_ = previous_ = current_ = dropped_ = 0; }
  bool full() const { return count_ == runs_.size(); }
  std::uint32_t count() const { return count_; }
  std::uint32_t dropped() const { return dropped_; }
  void drop(std::uint32_t n) { dropped_ += n; }
  const Run* begin() const { return runs_.data(); }
  const Run* end() const { return runs_.data() + count_; }

  /// Runs of a row from left to right, then end_row(); rows from top to bottom.
  void add(std::uint32_t y, std::uint32_t x0, std::uint32_t x1) {
    if (full()) [[unlikely]] {
      ++dropped_;
      return;
    }
    runs_[count_] = {static_cast<std::uint16_t>(y), static_cast<std::uint16_t>(x0), static_cast<std::uint16_t>(x1), 0,
                     count_};
    ++count_;
  }

  void end_row() {
    Run* const r = runs_.data();
    std::uint32_t i = previous_, j = current_;
    while (i < current_ && j < count_) {
      const Run &p = r[i], &q = r[j];
      if (p.x1 >= q.x0 && q.x1 >= p.x0) {  // ends are one past: touching corners count
        const std::uint32_t u = root(i), v = root(j);
        if (u != v) r[std::max(u, v)].label = std::min(u, v);
      }
      if (p.x1 < q.x1)
        ++i;
      else
        ++j;
    }
    previous_ = current_;
    current_ = count_;
  }

  /// Sums the regions up into `regions` (room for count() of them), ordered by their first run in raster order, and
  /// leaves each run's label as the number of its region. Returns how many there are.
  std::uint32_t finish(std::uint32_t colour, Blob* regions) {
    std::uint32_t n = 0;
    Run* const r = runs_.data();
    for (std::uint32_t i = 0; i < count_; ++i) {
      // A run always points at itself or at an earlier one, and that one's label is final by now.
      Run& run = r[i];
      if (run.label == i) {
        regions[n] = {.colour = colour, .x0 = run.x0, .y0 = run.y, .x1 = run.x0, .y1 = run.y, .region = n};
        run.label = n++;
      } else {
        run.label = r[run.label].label;
      }
      Blob& b = regions[run.label];
      const std::uint32_t length = std::uint32_t{run.x1} - run.x0;
      b.area_px += length;
      b.x0 = std::min(b.x0, run.x0);
      b.x1 = std::max(b.x1, static_cast<std::uint16_t>(run.x1 - 1));
      b.y1 = run.y;
      ++b.runs;
      b.sum_x += (std::uint32_t{run.x0} + run.x1 - 1) * length / 2;
      b.sum_y += std::uint32_t{run.y} * length;
    }
    return n;
  }

 private:
  std::uint32_t root(std::uint32_t i) {
    Run* const r = runs_.data();
    while (r[i].label != i) i = r[i].label = r[r[i].label].label;
    return i;
  }

  std::vector<Run> runs_;
  std::uint32_t count_ = 0, previous_ = 0,
                current_ = 0;  // first run of the row before: previous_; of this row: current_
  std::uint32_t dropped_ = 0;
};

}  // namespace sinew::vision
