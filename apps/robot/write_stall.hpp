#pragma once
// How long the disk of the recordings stalls, and what memory a recorder needs to lose nothing meanwhile.
#include <string>

#include "apps/robot_file/record_options.hpp"
#include "hal/file.hpp"
#include "hal/linux/system_check.hpp"
#include "hal/os.hpp"
#include "rt/graph.hpp"

namespace sinew::app {

struct WriteStall {
  hal::Duration worst{};  // of one write with its sync
  hal::Duration length{};
  std::uint64_t bytes = 0;
};

/// Writes for so long as a recorder does: `bytes_per_s`, with a sync behind every 256 KiB. What comes due during a
/// stall is written behind it.   Thread: owner.
/// Errors:  those of the file.
hal::Result<WriteStall> measure_write_stall(hal::OutputFile& file, hal::Os& os, double bytes_per_s,
                                            hal::Duration length);

/// What a recording of this checked robot takes, at most: all messages at their planned rates, the steps, and pixels as
/// far as their budget goes; before compression.
double recorded_bytes_per_s(const rt::Graph& graph, const RecordOptions& record);

/// What to say of it: a warning when `record.buffer_mb` does not suffice for the worst stall and half as much again.
hal::SystemCheck write_stall_check(const WriteStall& stall, double bytes_per_s, const RecordOptions& record);

/// Measures in the folder of the recordings, in a file that is removed again.
hal::SystemCheck check_write_stall(const RecordOptions& record, double bytes_per_s, double seconds);

}  // namespace sinew::app
