#include "apps/sweep_runs/pack.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>

#include "apps/command/place.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

constexpr hal::Duration kPatience{std::int64_t{120} * 1'000'000'000};

// The C library comes with the kernel's loader, which a program names by its path: the machine's own ones are used.
constexpr std::array kOfSystem{"ld-linux", "linux-vdso", "libc.so.",   "libm.so.",   "libmvec.so.", "libdl.so.",
                               "librt.so", "libpthread", "libresolv.", "libutil.so", "libanl.so.",  "libnss_"};

// The software rasteriser, which libEGL looks for at run time; pictures depend on it.
constexpr const char* kEgl = "libEGL.so.1";
constexpr const char* kVendor = "libEGL_mesa.so.0";
constexpr const char* kDriver = "dri/swrast_dri.so";
constexpr const char* kVendorFile =
    "{\"file_format_version\": \"1.0.0\", \"ICD\": {\"library_path\": \"libEGL_mesa.so.0\"}}\n";

/// What a program writes to standard output. Errors: false, with `why`.
bool output_of(const std::vector<std::string>& argv, std::string& output, std::string& why) {
  auto child = hal::ChildProcess::start(argv, hal::ChildOptions{.piped = true});
  std::string errors;
  if (!child) {
    why = fmt::format("{}: {}", argv.front(), hal::to_string(child.error().code));
    return false;
  }
  hal::ChildProcess* const one = child->get();
  std::vector<std::size_t> ready;
  const hal::Time end = hal::system_os().now() + kPatience;
  std::optional<int> code;
  while (!(code = one->poll()) && hal::system_os().now() < end) {
    hal::ChildProcess::wait_for_any({&one, 1}, hal::Duration{1'000'000'000}, ready);
    one->read_output(output, errors);
  }
  while (one->read_output(output, errors)) continue;
  if (code && *code == 0) return true;
  why = fmt::format("{}: {}", argv.front(), !code ? "no answer" : errors.empty() ? "failed" : errors);
  return false;
}

bool copy_file(const fs::path& from, const fs::path& to, std::string& why) {
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (!error) fs::copy_file(from, to, error);
  if (error) why = fmt::format("{}: cannot be copied to {}: {}", from.string(), to.string(), error.message());
  return !error;
}

bool write_file(const fs::path& path, std::string_view text, std::string& why) {
  std::ofstream out(path, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) why = path.string() + ": cannot be written";
  return static_cast<bool>(out);
}

class Packing {
 public:
  Packing(const PackRequest& request, fs::path folder) : request_(request), folder_(std::move(folder)) {}

  bool make(Packed& packed, std::string& why) {
    return put_programs(why) && put_libraries(why) && put_script(why) && put_files(why) && put_sums(packed, why);
  }

 private:
  bool put(const fs::path& from, const std::string& name, std::string& why) {
    if (!put_.insert(name).second) {
      why = fmt::format("{}: the folder has a file of this name of its own", name);
      return false;
    }
    return copy_file(from, folder_ / name, why);
  }

  bool put_text(const std::string& name, std::string_view text, std::string& why) {
    put_.insert(name);
    return write_file(folder_ / name, text, why);
  }

  bool put_programs(std::string& why) {
    const std::string plant = find_program("sinew-sim");
    if (!put(hal::program_path(), "bin/sinew", why)) return false;
    linked_.push_back(hal::program_path());
    if (plant.empty()) return true;  // a robot that needs it was refused
    linked_.push_back(plant);
    return put(plant, "bin/sinew-sim", why);
  }

  bool add_libraries_of(const std::string& file, std::string& why) {
    const std::string ldd = find_program("ldd");
    std::string listing;
    std::vector<Library> libraries;
    if (ldd.empty()) {
      why = "ldd is not there, which tells the libraries of a program";
      return false;
    }
    if (!output_of({ldd, file}, listing, why)) return false;
    if (!read_ldd(listing, libraries, why)) {
      why = fmt::format("{}: {}", file, why);
      return false;
    }
    for (const Library& library : libraries) libraries_.emplace(library.name, library.path);
    return true;
  }

  bool put_libraries(std::string& why) {
    for (const std::string& file : linked_)
      if (!add_libraries_of(file, why)) return false;
    if (const auto egl = libraries_.find(kEgl); egl != libraries_.end()) {
      const fs::path folder = fs::path(egl->second).parent_path();
      std::error_code error;
      if (!fs::exists(folder / kVendor, error) || !fs::exists(folder / kDriver, error)) {
        why = fmt::format("{}: no software rasteriser {} and {} beside it, which draws pictures", egl->second, kVendor,
                          kDriver);
        return false;
      }
      if (!add_libraries_of(folder / kVendor, why) || !add_libraries_of(folder / kDriver, why)) return false;
      libraries_.emplace(kVendor, folder / kVendor);
      if (!put(folder / kDriver, fmt::format("lib/{}", kDriver), why)) return false;
      if (!put_text("lib/egl_vendor.json", kVendorFile, why)) return false;
    }
    return std::all_of(libraries_.begin(), libraries_.end(),
                       [&](const auto& library) { return put(library.second, "lib/" + library.first, why); });
  }

  bool put_files(std::string& why) {
    for (const std::string& name : request_.files) {
      if (!stays_below(name)) {
        why = fmt::format(
            "{}: results name files as the command does, so that a folder for other machines takes only names below "
            "the current folder",
            name);
        return false;
      }
      if (!put(name, fs::path(name).lexically_normal(), why)) return false;
    }
    return true;
  }

  bool put_script(std::string& why) {
    std::string options;
    for (const std::string& word : request_.words) {
      if (word.find('\n') != std::string::npos) {
        why = fmt::format("{}: an option with a line break cannot be packed", word);
        return false;
      }
      options += word + "\n";
    }
    std::error_code error;
    if (!put_text("options", options, why) || !put_text("run", pack_script(), why)) return false;
    fs::permissions(folder_ / "run", fs::perms{0755}, error);
    if (error) why = fmt::format("run: {}", error.message());
    return !error;
  }

  bool put_sums(Packed& packed, std::string& why) {
    std::vector<std::string> argv{"/bin/sh", "-c", "cd \"$1\" && shift && exec sha256sum -- \"$@\"", "sh", folder_};
    argv.insert(argv.end(), put_.begin(), put_.end());
    std::string sums;
    if (!output_of(argv, sums, why)) return false;
    std::error_code error;
    for (const std::string& name : put_) packed.bytes += fs::file_size(folder_ / name, error);
    packed.files = put_.size() + 1;
    return write_file(folder_ / "SHA256SUMS", sums, why);
  }

  const PackRequest& request_;
  const fs::path folder_;
  std::set<std::string> put_{};
  std::vector<std::string> linked_{};
  std::map<std::string, std::string> libraries_{};
};

}  // namespace

bool read_ldd(const std::string& listing, std::vector<Library>& libraries, std::string& why) {
  std::istringstream lines(listing);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, arrow, path;
    words >> name >> arrow >> path;
    if (arrow != "=>") continue;  // the loader, the kernel's page, "statically linked"
    if (std::any_of(kOfSystem.begin(), kOfSystem.end(), [&](const char* own) { return name.starts_with(own); }))
      continue;
    if (path.empty() || path.front() != '/') {
      why = fmt::format("its library {} is not found", name);
      return false;
    }
    libraries.push_back({name, path});
  }
  return true;
}

bool stays_below(const std::string& name) {
  const fs::path path = fs::path(name).lexically_normal();
  return !path.empty() && path.is_relative() && *path.begin() != "..";
}

bool pack_sweep(const PackRequest& request, Packed& packed, std::string& why) {
  const fs::path folder = fs::absolute(request.folder).lexically_normal();
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    why = fmt::format("{}: is there already, and not empty", request.folder);
    return false;
  }
  // Under another name until all is there, so that a part is never taken for a whole.
  const fs::path part = (folder.has_filename() ? folder : folder.parent_path()).string() + ".part";
  fs::remove_all(part, error);
  if (!error) fs::create_directories(part, error);
  if (error) {
    why = fmt::format("{}: {}", part.string(), error.message());
    return false;
  }
  bool made = Packing(request, part).make(packed, why);
  if (made) {
    fs::remove(folder, error);
    if (!error) fs::rename(part, folder, error);
    if (error) why = fmt::format("{}: {}", request.folder, error.message());
    made = !error;
  }
  if (!made) fs::remove_all(part, error);  // what cannot be removed has a name that says what it is
  return made;
}

}  // namespace sinew::app
