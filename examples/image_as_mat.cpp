// An image message through OpenCV without a copy: read as a cv::Mat, and written in place through another.
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "msg/image_buffer.hpp"
#include "vision/opencv/mat_view.hpp"

int main() {
  using namespace sinew;
  msg::ImageBuffer camera(msg::PixelFormat::bgr8, 320, 240), grey(msg::PixelFormat::mono8, 320, 240);
  const cv::Mat view = vision::mat_view(*camera);
  cv::circle(view, {160, 120}, 40, {40, 90, 230}, cv::FILLED);  // draws into the message

  const vision::ReadOnlyMat in(*camera);
  cv::Mat out = vision::mat_view(*grey);
  cv::cvtColor(*in, out, cv::COLOR_BGR2GRAY);

  const bool in_place = out.data == (*grey).pixels() && in->data == (*camera).pixels();
  std::printf("%d grey pixels, %s\n", cv::countNonZero(out), in_place ? "written in place" : "copied somewhere");
  return in_place && cv::countNonZero(out) > 4000 ? 0 : 1;
}
