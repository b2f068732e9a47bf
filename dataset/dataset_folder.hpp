#pragma once
#include <string>
#include <vector>

#include "dataset/dataset_files.hpp"
#include "dataset/png_image.hpp"
#include "hal/result.hpp"

namespace sinew::dataset {

/// Reads the whole file into `out`. False: it cannot be read. `why` says why, and stays empty when there is no such
/// file.
bool read_file(const std::string& path, std::string& out, std::string& why);

/// A recorded folder, either in the EuRoC/ASL form
///     mav0/imu0/data.csv, mav0/cam0/data.csv, mav0/cam0/data/*.png
/// or flat
///     imu0.csv, cam0/<stamp in ns>.png
/// Either part may be missing, not both. Stamps are the dataset's own.
struct DatasetFolder {
  std::vector<msg::ImuSample> imu;
  std::vector<ImageEntry> images;
  std::string image_folder;  // with a slash at its end

  /// Errors:  not_found when there is neither; bad_data or io, with the place ("file:line: ...") in `why`.
  static hal::Result<DatasetFolder> open(const std::string& folder, std::string& why);
  /// Errors:  io or bad_data, with the file in `why`.
  hal::Status decode(const ImageEntry& image, DecodedImage& out, std::string& why) const;
};

}  // namespace sinew::dataset
