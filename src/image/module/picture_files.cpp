// read_write.h and picture_file.h through OpenImageIO.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <mutex>

#include "image/module/pixels.h"
#include "image/picture_calls.h"
#include "image/picture_library.h"
#include "image/read_write.h"

namespace kinora::image {
namespace {

namespace oiio = OIIO;

StoredType storedType(const oiio::TypeDesc& t) {
  switch (t.basetype) {
    case oiio::TypeDesc::UINT8:
    case oiio::TypeDesc::INT8:
      return StoredType::UInt8;
    case oiio::TypeDesc::UINT16:
    case oiio::TypeDesc::INT16:
      return StoredType::UInt16;
    case oiio::TypeDesc::HALF:
      return StoredType::Half;
    default:
      return StoredType::Float;
  }
}

oiio::TypeDesc typeDesc(StoredType t) {
  switch (t) {
    case StoredType::UInt8:
      return oiio::TypeUInt8;
    case StoredType::UInt16:
      return oiio::TypeUInt16;
    case StoredType::Half:
      return oiio::TypeHalf;
    case StoredType::Float:
      break;
  }
  return oiio::TypeFloat;
}

void setUpLibrary() {
  static std::once_flag once;
  std::call_once(once, [] {
    // errors come back through return values; a decoder's own threads would fight the renderer's
    oiio::attribute("threads", 1);
    oiio::attribute("exr_threads", -1);
  });
}

void readMetadata(const oiio::ImageSpec& spec, Image& out) {
  for (const oiio::ParamValue& p : spec.extra_attribs) {
    const std::string name = p.name().string();
    if (p.type() == oiio::TypeInt)
      out.metadata[name] = p.get<int>();
    else if (p.type() == oiio::TypeFloat)
      out.metadata[name] = p.get<float>();
    else if (p.type() == oiio::TypeString)
      out.metadata[name] = p.get_ustring().string();
    else if (p.type() == oiio::TypeMatrix) {
      Matrix44 m;
      std::memcpy(m.data(), p.data(), sizeof m);
      out.metadata[name] = m;
    }
  }
}

std::string quoted(const std::string& path) { return "\"" + path + "\""; }

// Opens and checks; on success `input` is at the first subimage and `out` has everything but pixels.
Status open(const std::string& path, Image& out, const ReadOptions& options,
            std::unique_ptr<oiio::ImageInput>& input) {
  setUpLibrary();
  struct stat info;
  if (stat(path.c_str(), &info) != 0)
    return Status::fail("IMAGE-OPEN", "cannot open " + quoted(path) + ": " + std::strerror(errno));
  // colours as they stand beside alpha, not multiplied by it
  oiio::ImageSpec asStored;
  asStored.attribute("oiio:UnassociatedAlpha", 1);
  input = oiio::ImageInput::open(path, &asStored);
  if (!input) {
    std::string why = oiio::geterror();
    return Status::fail(
        "IMAGE-OPEN", "cannot read " + quoted(path) + ": " + (why.empty() ? "unknown format or broken header" : why));
  }
  const oiio::ImageSpec& spec = input->spec();
  const int64_t w = spec.width, h = spec.height, c = spec.nchannels;
  if (w < 1 || h < 1 || c < 1 || spec.depth > 1 || c > options.maxChannels || w > (1 << 20) || h > (1 << 20) ||
      std::abs(int64_t(spec.x)) > (1 << 28) || std::abs(int64_t(spec.y)) > (1 << 28) ||
      std::abs(int64_t(spec.full_x)) > (1 << 28) || std::abs(int64_t(spec.full_y)) > (1 << 28) ||
      spec.full_width < 0 || spec.full_height < 0 || spec.full_width > (1 << 28) || spec.full_height > (1 << 28))
    return Status::fail("IMAGE-SIZE", quoted(path) + " says it has " + std::to_string(w) + " x " + std::to_string(h) +
                                          " pixels of " + std::to_string(c) + " channels; that is not believed");
  if (!blocksAreBelievable(spec))
    return Status::fail("IMAGE-SIZE", quoted(path) + " has strips or tiles of a size that is not believed");
  // no compression in use shrinks pictures below 1/16,384 of their floats; small pictures are let through
  const uint64_t bytes = uint64_t(w) * uint64_t(h) * uint64_t(c) * sizeof(float);
  const uint64_t plausible = (uint64_t(1) << 28) + uint64_t(info.st_size) * 16384;
  if (bytes > options.maxBytes || bytes > plausible)
    return Status::fail("IMAGE-SIZE", quoted(path) + " says it has " + std::to_string(w) + " x " + std::to_string(h) +
                                          " pixels of " + std::to_string(c) + " channels, " +
                                          std::to_string(bytes >> 20) + " MiB; that is too much for " +
                                          (bytes > plausible ? "a file of its length" : "the limit"));
  out.data = {spec.x, spec.y, spec.x + spec.width, spec.y + spec.height};
  out.display = {spec.full_x, spec.full_y, spec.full_x + spec.full_width, spec.full_y + spec.full_height};
  for (int i = 0; i < spec.nchannels; ++i)
    out.channels.push_back({spec.channelnames[size_t(i)], storedType(spec.channelformat(i))});
  readMetadata(spec, out);
  out.metadata["format"] = std::string(input->format_name());
  return {};
}

Status readFile(const std::string& path, Image& out, const ReadOptions& options, bool headerAlone) {
  out = {};
  try {
    std::unique_ptr<oiio::ImageInput> input;
    if (Status s = open(path, out, options, input); !s.ok() || headerAlone) {
      if (!s.ok()) out = {};
      return s;
    }
    out.pixels.resize(size_t(out.data.pixels()) * out.channels.size());
    if (!readPixels(*input, out.channelCount(), out.pixels.data())) {
      out = {};
      return Status::fail("IMAGE-READ", "cannot read the pixels of " + quoted(path) + ": " + input->geterror());
    }
    // truncated JPEG and PNG files may be read "successfully" with a warning only
    if (const std::string why = input->geterror(); !why.empty()) {
      out = {};
      return Status::fail("IMAGE-READ", "cannot read all pixels of " + quoted(path) + ": " + why);
    }
    return {};
  } catch (const std::exception& e) {
    out = {};
    return Status::fail("IMAGE-READ", "cannot read " + quoted(path) + ": " + e.what());
  }
}

const char* nameOf(Compression c) {
  static const char* const kNames[] = {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
  return kNames[int(c)];
}

void setAttribute(oiio::ImageSpec& spec, const std::string& key, const MetaValue& value) {
  if (const int* i = std::get_if<int>(&value)) spec.attribute(key, *i);
  if (const float* f = std::get_if<float>(&value)) spec.attribute(key, *f);
  if (const std::string* s = std::get_if<std::string>(&value)) spec.attribute(key, *s);
  if (const Matrix44* m = std::get_if<Matrix44>(&value)) spec.attribute(key, oiio::TypeMatrix, m->data());
}

void describe(const Image& image, oiio::ImageSpec& spec) {
  spec.x = image.data.x0;
  spec.y = image.data.y0;
  spec.full_x = image.display.x0;
  spec.full_y = image.display.y0;
  spec.full_width = image.display.width();
  spec.full_height = image.display.height();
  spec.channelnames.clear();
  for (const ChannelInfo& c : image.channels) spec.channelnames.push_back(c.name);
  for (size_t i = 0; i < image.channels.size(); ++i) {
    if (image.channels[i].name == "A") spec.alpha_channel = int(i);
    if (image.channels[i].name == "Z") spec.z_channel = int(i);
  }
  for (const auto& [key, value] : image.metadata) {
    if (key == "format") continue;  // added by read()
    setAttribute(spec, key, value);
  }
}

// Integers as the file holds them, rounded here so that the library's conversion has no say.
template <typename Int, typename Encode, typename Plain>
std::vector<Int> quantized(const Image& image, const std::vector<int>& channels, Encode encode, Plain plain) {
  std::vector<Int> out;
  out.reserve(size_t(image.data.pixels()) * channels.size());
  const size_t pixels = size_t(image.data.pixels());
  for (size_t i = 0; i < pixels; ++i)
    for (const int c : channels) {
      const float v = image.pixels[i * image.channels.size() + size_t(c)];
      out.push_back(isAlphaName(image.channels[size_t(c)].name) ? plain(v) : encode(v));
    }
  return out;
}

// `what`: before the reason of a failure.
Status writeBytes(const std::string& path, const std::string& what, const std::vector<unsigned char>& bytes) {
  std::FILE* f = std::fopen(path.c_str(), "wb");
  int error = f ? 0 : errno;
  if (f && std::fwrite(bytes.data(), 1, bytes.size(), f) != bytes.size()) error = errno ? errno : EIO;
  if (f && std::fclose(f) != 0 && !error) error = errno;
  if (error) return Status::fail("IMAGE-WRITE", what + std::strerror(error));
  return {};
}

Status writeFile(const std::string& temporary, const std::string& path, const Image& image,
                 const WriteOptions& options) {
  setUpLibrary();
  const std::string extension = extensionOf(path);
  try {
    std::unique_ptr<oiio::ImageOutput> output = oiio::ImageOutput::create(path);
    if (!output) {
      (void)oiio::geterror();
      return Status::fail("IMAGE-FORMAT", "cannot write " + quoted(path) +
                                              ": no picture format has the extension \"" + extension +
                                              "\"; use .exr, .png, .tif or .jpg");
    }
    const bool isExr = extension == "exr", isJpeg = extension == "jpg" || extension == "jpeg";
    const bool isFloatFormat = isExr || (output->supports("channelformats")) ||
                               ((extension == "tif" || extension == "tiff" || extension == "hdr") &&
                                image.channels[0].type >= StoredType::Half);
    // formats of a few channels take the first ones: RGB(A), or grey
    std::vector<int> channels;
    const bool isColourAlone = isJpeg || extension == "bmp" || extension == "ppm" || extension == "hdr";
    const int most = isColourAlone                                                ? 3
                     : isFloatFormat || extension == "tif" || extension == "tiff" ? image.channelCount()
                                                                                  : 4;
    for (int c = 0; c < std::min(most, image.channelCount()); ++c) channels.push_back(c);
    if (isColourAlone && channels.size() == 2) channels.pop_back();

    oiio::ImageSpec spec(image.width(), image.height(), int(channels.size()), oiio::TypeFloat);
    describe(image, spec);
    spec.channelnames.resize(channels.size());
    if (spec.alpha_channel >= spec.nchannels) spec.alpha_channel = -1;
    if (spec.z_channel >= spec.nchannels) spec.z_channel = -1;
    // Through memory where the format allows it: several of the libraries do not notice a full disk.
    oiio::Filesystem::IOVecOutput memory;
    // (Not TIFF: its directory, written last, comes out of OpenImageIO 2.4's memory file cut short.)
    const bool isInMemory = output->supports("ioproxy") && extension != "tif" && extension != "tiff";
    if (isInMemory) output->set_ioproxy(&memory);
    bool ok = false;
    if (isFloatFormat) {
      spec.set_format(typeDesc(image.channels[0].type));
      if (isExr) {
        std::vector<oiio::TypeDesc> formats;
        for (const ChannelInfo& c : image.channels)
          formats.push_back(c.type == StoredType::Float ? oiio::TypeFloat : oiio::TypeHalf);
        const bool isMixed = std::any_of(formats.begin(), formats.end(), [&](auto f) { return f != formats[0]; });
        spec.set_format(isMixed ? oiio::TypeFloat : formats[0]);
        if (isMixed) spec.channelformats = formats;
        std::string compression = nameOf(options.compression);
        if (options.compression == Compression::Dwaa || options.compression == Compression::Dwab)
          compression += ":" + std::to_string(int(options.dwaLevel));
        spec.attribute("compression", compression);
        if (options.isTiled) spec.tile_width = spec.tile_height = 64;
      }
      std::vector<float> held;  // where the format has not room for all channels
      for (size_t i = 0; channels.size() != image.channels.size() && i < image.pixels.size();
           i += image.channels.size())
        held.insert(held.end(), &image.pixels[i], &image.pixels[i] + channels.size());
      ok = output->open(temporary, spec) &&
           output->write_image(oiio::TypeFloat, held.empty() ? image.pixels.data() : held.data());
    } else {
      const bool is16 = !isJpeg && std::all_of(image.channels.begin(), image.channels.end(),
                                               [](const ChannelInfo& c) { return c.type == StoredType::UInt16; });
      spec.set_format(is16 ? oiio::TypeUInt16 : oiio::TypeUInt8);
      // 8-bit files are pictures to look at: the crop stands at its place only where the format can say so
      spec.attribute("oiio:ColorSpace", options.encodeSrgb ? "sRGB" : "linear");
      // the library would divide codes; TIFF says that its colours are multiplied
      if (extension != "tif" && extension != "tiff") spec.attribute("oiio:UnassociatedAlpha", 1);
      if (isJpeg) spec.attribute("CompressionQuality", std::clamp(options.jpegQuality, 1, 100));
      if (is16) {
        const auto plain = [](float v) { return uint16_t(!(v > 0) ? 0 : v >= 1 ? 65535 : v * 65535.0f + 0.5f); };
        const auto data = options.encodeSrgb ? quantized<uint16_t>(image, channels, encodeSrgb16, plain)
                                             : quantized<uint16_t>(image, channels, plain, plain);
        ok = output->open(temporary, spec) && output->write_image(oiio::TypeUInt16, data.data());
      } else {
        const auto data = options.encodeSrgb ? quantized<uint8_t>(image, channels, encodeSrgb8, quantize8)
                                             : quantized<uint8_t>(image, channels, quantize8, quantize8);
        ok = output->open(temporary, spec) && output->write_image(oiio::TypeUInt8, data.data());
      }
    }
    const std::string why = output->geterror();
    ok = output->close() && ok;
    if (!ok)
      return Status::fail("IMAGE-WRITE", "cannot write " + quoted(path) + ": " +
                                             (why.empty() ? std::string("the file could not be finished") : why));
    if (isInMemory) {
      if (Status s = writeBytes(temporary, "cannot write " + quoted(path) + ": ", memory.buffer()); !s.ok()) return s;
    } else {
      Image back;
      if (Status s = readFile(temporary, back, {}, false); !s.ok())
        return Status::fail("IMAGE-WRITE", "cannot write " + quoted(path) + ": what was written cannot be read back");
    }
  } catch (const std::exception& e) {
    return Status::fail("IMAGE-WRITE", "cannot write " + quoted(path) + ": " + e.what());
  }
  return {};
}

bool pngOf(int width, int height, int channels, const unsigned char* codes, std::vector<unsigned char>& out) {
  const oiio::ImageSpec spec(width, height, channels, oiio::TypeUInt8);
  oiio::Filesystem::IOVecOutput memory;
  const auto output = oiio::ImageOutput::create("png");
  if (!output || !output->set_ioproxy(&memory) || !output->open("memory.png", spec) ||
      !output->write_image(oiio::TypeUInt8, codes) || !output->close())
    return false;
  out = memory.buffer();
  return true;
}

oiio::ImageSpec specOf(const PictureFormat& format) {
  oiio::ImageSpec spec(format.data.width(), format.data.height(), format.channels, typeDesc(format.type));
  spec.x = format.data.x0;
  spec.y = format.data.y0;
  spec.full_width = format.fullWidth;
  spec.full_height = format.fullHeight;
  if (!format.names.empty()) {
    spec.channelnames = format.names;
    spec.alpha_channel = format.alphaChannel;
  }
  for (const auto& [key, value] : format.attributes) setAttribute(spec, key, value);
  return spec;
}

// The library's writers do not notice a full disk. Small files are encoded in memory and written whole at the end; a
// TIFF file, whose directory comes out of OpenImageIO 2.4's memory file cut short, is read back.
class LibraryFile final : public PictureFile {
 public:
  explicit LibraryFile(const PictureFormat& format)
      : path_(format.path), spec_(specOf(format)), isInMemory_(format.format != "tiff") {}

  Status open(const std::string& format) {
    output_ = oiio::ImageOutput::create(format);
    if (!output_) {
      (void)oiio::geterror();
      return failed("this OpenImageIO cannot write " + format);
    }
    if (isInMemory_ && !output_->set_ioproxy(&memory_)) return failed("it cannot be encoded in memory");
    return output_->open(path_, spec_) ? Status() : failed(output_->geterror());
  }
  Status write(int first, int count, const void* pixels) override {
    // one call for a whole picture: formats may take it at once only
    const bool isWritten =
        first == 0 && count == spec_.height
            ? output_->write_image(spec_.format, pixels)
            : output_->write_scanlines(spec_.y + first, spec_.y + first + count, spec_.z, spec_.format, pixels);
    return isWritten ? Status() : failed(output_->geterror());
  }
  Status close() override {
    if (!output_->close()) return failed(output_->geterror());
    output_.reset();
    if (isInMemory_) return writeBytes(path_, "", memory_.buffer());
    return isReadBack() ? Status() : failed("what was written cannot be read back");
  }

 private:
  // The library may fail without a word.
  static Status failed(const std::string& why) {
    return Status::fail("IMAGE-WRITE", why.empty() ? "the file could not be finished" : why);
  }
  bool isReadBack() const {
    const auto back = oiio::ImageInput::open(path_);
    if (!back) {
      (void)oiio::geterror();
      return false;
    }
    std::vector<unsigned char> pixels(back->spec().image_bytes(true));
    return back->spec().width == spec_.width && back->spec().height == spec_.height &&
           back->read_image(0, 0, 0, back->spec().nchannels, oiio::TypeUnknown, pixels.data());
  }

  std::string path_;
  oiio::ImageSpec spec_;
  bool isInMemory_;
  oiio::Filesystem::IOVecOutput memory_;
  std::unique_ptr<oiio::ImageOutput> output_;
};

Status openFile(const PictureFormat& format, std::unique_ptr<PictureFile>& out) {
  setUpLibrary();
  auto file = std::make_unique<LibraryFile>(format);
  Status s = file->open(format.format);
  if (s.ok()) out = std::move(file);
  return s;
}

}  // namespace
}  // namespace kinora::image

KINORA_PICTURE_LIBRARY_EXPORT(kinora::image::VersionText, kinoraPictureLibraryVersion) = KINORA_VERSION;
KINORA_PICTURE_LIBRARY_EXPORT(kinora::image::PictureCalls, kinoraPictureCalls){
    kinora::image::readFile, kinora::image::writeFile, kinora::image::pngOf, kinora::image::openFile};
