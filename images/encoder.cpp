#include "images/encode.hpp"
#include "images/file_writers.hpp"

namespace sinew::images {

std::optional<Kind> kind_of(std::string_view ending) {
  if (ending == "jpg" || ending == "jpeg") return Kind::jpeg;
  if (ending == "png") return Kind::png;
  if (ending == "tif" || ending == "tiff") return Kind::tiff;
  if (ending == "bmp") return Kind::bmp;
  return std::nullopt;
}

const char* media_type(Kind kind) {
  switch (kind) {
    case Kind::jpeg:
      return "image/jpeg";
    case Kind::png:
      return "image/png";
    case Kind::tiff:
      return "image/tiff";
    case Kind::bmp:
      return "image/bmp";
  }
  return "application/octet-stream";
}

bool is_built(Kind kind) { return kind != Kind::jpeg || JpegWriter::built(); }

struct Encoder::Parts {
  RowSource rows;
  PngWriter png;
  JpegWriter jpeg;
  Buffer<std::uint8_t> out;
};

Encoder::Encoder() : parts_(new (std::nothrow) Parts) {}
Encoder::~Encoder() = default;

hal::Result<std::span<const std::byte>> Encoder::encode(const PixelView& view, Kind kind, const Cut& cut,
                                                        const EncodeOptions& options) noexcept {
  if (!parts_) return no_memory();
  const hal::Result<Area> area = area_of(view, cut);
  if (!area) return area.error();
  if (kind == Kind::jpeg) {
    if (options.quality < 1 || options.quality > 100)
      return hal::Error{hal::Errc::bad_argument, "quality: 1 to 100", options.quality};
    return parts_->jpeg.write(view, parts_->rows, *area, options, parts_->out);
  }
  RowSource::Order order = RowSource::Order::bgr;
  if (kind != Kind::bmp)
    order = view.format == msg::PixelFormat::mono8 ? RowSource::Order::grey : RowSource::Order::rgb;
  if (!parts_->rows.start(view, *area, order)) return no_memory();
  if (kind == Kind::png) return parts_->png.write(parts_->rows, *area, parts_->out);
  if (kind == Kind::tiff) return write_tiff(parts_->rows, *area, parts_->out);
  return write_bmp(parts_->rows, *area, parts_->out);
}

}  // namespace sinew::images
