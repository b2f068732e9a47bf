#pragma once
// A printed chessboard in the pictures of a recording.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "vision/board_finder.hpp"

namespace sinew::app {

struct SeenBoard {
  std::int64_t stamp_ns = 0;  // of the picture
  std::vector<vision::BoardCorner> corners;
  double moved_px = 0;  // the most that a corner moved from the picture before or to the one after, the smaller one;
                        // infinite: neither shows it
};

/// How far the corner moved that moved most.
double farthest_px(const SeenBoard& a, const SeenBoard& b);

struct RecordedBoards {
  std::string topic;
  std::uint32_t width = 0, height = 0;
  std::size_t pictures = 0;
  std::vector<SeenBoard> boards;     // of pictures that show it whole
  std::vector<std::uint8_t> sample;  // one of those pictures, mono8
};

/// Looks at each picture of a topic of images; an empty name: the only one. Nothing, with `why`: there is no such
/// topic, several, pictures of several sizes, pictures whose pixels were not recorded or have no grey values.
std::optional<RecordedBoards> read_boards(record::Reader& reader, const std::string& topic,
                                          const vision::BoardSize& size, std::string& why);

/// Up to so many that differ most from each other, in the order of their stamps: of those in which the board stood
/// still where there are ten of them, else of all.
std::vector<SeenBoard> choose_boards(const std::vector<SeenBoard>& all, std::size_t most);

}  // namespace sinew::app
