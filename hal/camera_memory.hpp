#pragma once
#include <cstdint>
#include <string>

#include "hal/result.hpp"
#include "msg/image.hpp"

namespace sinew::hal {

/// A camera that fills memory lent by its reader, so that no pixels are copied between the device and the topic's
/// readers. A camera that may be able to do so implements this beside hal::Camera: ask with dynamic_cast.
///
///   const auto images = memory->begin_lending(room, why);   // once, before the start
///   memory->lend(image);                                    // so many of them; each is the camera's from now on
///   const auto filled = memory->take_filled();              // and the reader's again, in the order of exposure
///
/// Thread:  owner (the reader's), except where "any" is said.
/// Owner:   a lent image belongs to the camera: do not touch it or its pixels until take_filled() or take_back() has
///          answered it. The camera never loses an image: while a device is gone the camera keeps the lent images, and
///          goes on with them when the device is back.
class CameraMemory {
 public:
  virtual ~CameraMemory() = default;
  /// From now on pictures go into lent images, and read() gives none. Answers how many images the camera works on at a
  /// time. `room_bytes`: for pixels, in each image. Before the start; not RT.
  /// Errors:  bad_argument: the camera was configured to lend or fail, and cannot lend; any other error: it cannot
  ///          lend, and goes on with read(). `why` has it in words.
  virtual Result<std::uint32_t> begin_lending(std::uint32_t room_bytes, std::string& why) = 0;
  /// RT: yes; the first time for each image the kernel pins its memory, which takes some 100 us.
  /// Errors:  busy: not now, try again in a later cycle; bad_argument: too many, or no room; not_supported: the driver
  ///          refuses such memory, read() gives pictures again from now on. The image stays the caller's.
  virtual Status lend(msg::Image& image) noexcept = 0;
  /// The oldest image that is filled, described as read() does it; null: none is ready. RT: yes.
  /// Errors:  closed, bad_data: as read(); not_supported: read() gives the pictures; take the lent images back.
  virtual Result<msg::Image*> take_filled() noexcept = 0;
  /// Ends the stream, and answers the lent images one after the other. Null: there is none, or the device still uses
  /// them. The next lend() begins the stream anew. RT: yes.
  virtual msg::Image* take_back() noexcept = 0;
  /// Waits until the device uses no image any more; take_back() then answers all. Not RT.
  virtual void stop_lending() noexcept = 0;
  /// "the driver fills the topic's slots", or why pixels are copied, for people. Thread: any.
  virtual std::string path_of_pixels() const = 0;
};

}  // namespace sinew::hal
