// The only place that hands files of volumes to OpenImageIO, which hands them to OpenVDB: damaged ones end or hang
// the process that runs this. No message but through the descriptor. In the library of picture files.
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <new>
#include <optional>

#include "image/picture_library.h"
#include "image/volume_file.h"
#include "volume/grid_stream.h"

namespace kinora::volume {

namespace {

// Buffered writes of records.
class GridWriter {
 public:
  explicit GridWriter(int descriptor) : descriptor_(descriptor) { buffer_.reserve(kBuffer); }
  void record(GridRecord kind, uint32_t count, const void* data, size_t bytes) {
    const uint32_t head[2] = {uint32_t(kind), count};
    put(head, sizeof head);
    put(data, bytes);
  }
  bool flush() {
    for (size_t at = 0; isGood_ && at < buffer_.size();) {
      const ssize_t n = ::write(descriptor_, buffer_.data() + at, buffer_.size() - at);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0)
        isGood_ = false;
      else
        at += size_t(n);
    }
    buffer_.clear();
    return isGood_;
  }
  bool isGood() const { return isGood_; }

 private:
  static constexpr size_t kBuffer = 1 << 18;
  void put(const void* data, size_t bytes) {
    if (bytes == 0) return;
    if (buffer_.size() + bytes > kBuffer) flush();
    const char* from = static_cast<const char*>(data);
    buffer_.insert(buffer_.end(), from, from + bytes);
  }
  int descriptor_;
  std::vector<char> buffer_;
  bool isGood_ = true;
};

// Grids in a camera's frustum: the library gives the linear part of their transform alone and does not say so.
bool namesFrustum(const std::string& path) {
  static constexpr char kName[] = "NonlinearFrustumMap";
  constexpr size_t kOverlap = sizeof kName - 2, kBlock = 1 << 20;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(kOverlap + kBlock);
  size_t kept = 0;
  while (file.read(block.data() + kept, kBlock), file.gcount() > 0) {
    const size_t n = kept + size_t(file.gcount());
    if (memmem(block.data(), n, kName, sizeof kName - 1)) return true;
    kept = std::min(n, kOverlap);
    std::memmove(block.data(), block.data() + n - kept, kept);
  }
  return false;
}

constexpr const char* kNoGrid = "it holds no grid of single floats or triples of them";
constexpr const char* kTooLarge = "reading it takes more memory than there is";

// "Could not open 'FILE': WHY" -> "WHY"
std::string reasonOf(std::string text) {
  if (const size_t line = text.find('\n'); line != std::string::npos) text.resize(line);
  if (const size_t colon = text.rfind("': "); colon != std::string::npos) text.erase(0, colon + 3);
  if (text.find("bad_alloc") != std::string::npos) return kTooLarge;
  return text.empty() ? "its reader gives no reason" : text;
}

std::string gridName(const OIIO::ImageSpec& spec) {
  const std::string name = spec.get_string_attribute("oiio:subimagename");
  return name.empty() ? std::string(spec.get_string_attribute("name")) : name;
}

// The number of the grid that is meant; -1 with `error`.
int find(OIIO::ImageInput& input, const std::string& which, std::string& error) {
  std::string names;
  int count = 0, byName = -1;
  const std::string wanted = which.empty() ? "density" : which[0] == '=' ? which.substr(1) : "";
  for (; count < 10000 && input.seek_subimage(count, 0); ++count) {
    const std::string name = gridName(input.spec());
    if (byName < 0 && name == wanted && (which.empty() || which[0] == '=')) byName = count;
    if (names.size() < 200) names += (count ? ", '" : "'") + name + "'";
  }
  if (count == 0) {
    error = kNoGrid;
    return -1;
  }
  if (byName >= 0) return byName;
  if (which.empty()) return 0;
  if (which[0] == '#') {
    char* end = nullptr;
    const long number = std::strtol(which.c_str() + 1, &end, 10);
    if (end && !*end && number >= 0 && number < count) return int(number);
    error = "it has no grid number " + which.substr(1) + "; it holds " + names;
    return -1;
  }
  error = "it has no grid '" + wanted + "'; it holds " + names;
  return -1;
}

std::string send(const std::string& path, const std::string& which, GridWriter& writer) {
  if (!image::holdsVolumes(path)) return "it holds no volumes (OpenVDB)";
  auto input = OIIO::ImageInput::create("openvdb");
  if (!input) return "OpenImageIO was built without OpenVDB";
  OIIO::ImageSpec opened;
  if (namesFrustum(path)) return "its grids lie in the frustum of a camera, which is not read";
  if (!input->open(path, opened)) {
    const std::string error = input->geterror();
    return error.empty() ? kNoGrid : reasonOf(error);
  }
  std::string error;
  const int number = find(*input, which, error);
  if (number < 0) return error;
  input->seek_subimage(number, 0);
  const OIIO::ImageSpec spec = input->spec();
  if (spec.format != OIIO::TypeFloat || spec.tile_width != GridShape::kSide || spec.tile_height != GridShape::kSide ||
      spec.tile_depth != GridShape::kSide)
    return "it is stored in bricks of an unknown kind";
  GridShape shape;
  shape.subimage = number;
  shape.channels = spec.nchannels;
  // the box of active voxels; that of the tiles is larger by a voxel at least
  const int first[3] = {spec.full_x, spec.full_y, spec.full_z};
  const int size[3] = {spec.full_width, spec.full_height, spec.full_depth};
  std::copy_n(first, 3, shape.first);
  std::copy_n(size, 3, shape.size);
  static const OIIO::TypeDesc kMatrix(OIIO::TypeDesc::DOUBLE, OIIO::TypeDesc::MATRIX44);
  if (!spec.getattribute("openvdb:worldtoindex", kMatrix, shape.worldToIndex)) return "its transform is not told";
  if (const char* why = shape.disbelief()) return why;
  writer.record(GridRecord::Shape, sizeof shape, &shape, sizeof shape);

  const size_t channels = size_t(shape.channels), floats = size_t(GridShape::kVoxels) * channels;
  std::vector<float> brick(floats);
  uint32_t at = 0, records = 0;
  // The library keeps each brick that it has been asked for until the file is closed. Opened anew, it reads where bricks
  // are and no brick.
  constexpr uint64_t kMostHeld = uint64_t(256) << 20;
  uint64_t held = 0;
  int place[3];
  for (place[2] = 0; place[2] < shape.bricks(2); ++place[2])
    for (place[1] = 0; place[1] < shape.bricks(1); ++place[1])
      for (place[0] = 0; place[0] < shape.bricks(0); ++place[0], ++at) {
        int corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = (shape.firstBrick(k) + place[k]) * GridShape::kSide;
        if (!input->read_native_tile(number, 0, corner[0], corner[1], corner[2], brick.data()))
          return reasonOf(input->geterror());
        const size_t bytes = channels * sizeof(float);
        const bool isConstant =
            std::memcmp(brick.data(), brick.data() + channels, floats * sizeof(float) - bytes) == 0;
        if (isConstant && std::all_of(brick.begin(), brick.begin() + long(channels), [](float x) { return x == 0; }))
          continue;
        writer.record(isConstant ? GridRecord::Constant : GridRecord::Brick, at, brick.data(),
                      isConstant ? bytes : floats * sizeof(float));
        ++records;
        if (!writer.isGood()) return "";
        held += floats * sizeof(float);
        if (held < kMostHeld) continue;
        held = 0;
        input->close();
        OIIO::ImageSpec again;
        if (!input->open(path, again) || !input->seek_subimage(number, 0)) return reasonOf(input->geterror());
      }
  writer.record(GridRecord::End, records, nullptr, 0);
  return "";
}

bool sendFile(const std::string& path, const std::string& which, int descriptor) {
  GridWriter writer(descriptor);
  std::string why;
  try {
    OIIO::attribute("threads", 1);
    // bricks are read of the file when they are asked for, not of a copy in a temporary folder
    ::unsetenv("OPENVDB_DISABLE_DELAYED_LOAD");
    ::setenv("OPENVDB_DELAYED_LOAD_COPY_MAX_BYTES", "0", 1);
    why = send(path, which, writer);
  } catch (const std::bad_alloc&) {
    why = kTooLarge;
  } catch (const std::exception& e) {
    why = reasonOf(e.what());
  }
  if (!why.empty())
    writer.record(GridRecord::Refusal, uint32_t(std::min<size_t>(why.size(), 1000)), why.data(),
                  std::min<size_t>(why.size(), 1000));
  return writer.flush();
}

}  // namespace
}  // namespace kinora::volume

KINORA_PICTURE_LIBRARY_EXPORT(kinora::volume::VolumeCalls, kinoraVolumeCalls){kinora::volume::sendFile};
