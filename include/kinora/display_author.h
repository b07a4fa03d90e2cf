// The author's layer of display drivers: a class whose functions may throw becomes the calls of display.h.
//
//   struct MyDriver {
//     MyDriver(const CreateInfo&, const DisplayInfo&);
//     void write(const DisplayPixels&);
//     void close();                       // not called after a failure; what the disk refuses shows here at the latest
//   };
//   KINORA_DISPLAY(mine, MyDriver, .help = "...", .params = kParams)       // ends the file, outside of namespaces
#pragma once
#include <kinora/display.h>

#include <memory>

namespace kinora {

template <class Driver>
struct DisplayCalls {
  static std::unique_ptr<Driver> make(const CreateInfo& info) {
    return std::make_unique<Driver>(info, *static_cast<const DisplayInfo*>(info.extra));
  }
  static int write(void* display, const DisplayPixels* pixels, ErrorText* error) {
    return guardedCall(error, [&] { static_cast<Driver*>(display)->write(*pixels); });
  }
  static int close(void* display, ErrorText* error) {
    return guardedCall(error, [&] { static_cast<Driver*>(display)->close(); });
  }
  static void abort(void*) {}  // destroy() forgets the picture
  static constexpr DisplayFunctions kFunctions{write, close, abort};
};

// What a display driver declares.
template <class Driver>
struct DisplayPlugin {
  using Functions = DisplayFunctions;
  static constexpr Kind kKind = Kind::Display;
  static constexpr SetUp setUp = setUpBy<&DisplayCalls<Driver>::make>;
  const char* help = "";
  ListOf<Param> params = {};
  int32_t straightAlpha = 0;
  int32_t pictureFiles = 0;
  constexpr DisplayTraits traits() const { return {straightAlpha, pictureFiles}; }
};

#define KINORA_DISPLAY(Name, Driver, ...) \
  KINORA_SCALAR_PLUGIN(Name, DisplayCalls<Driver>::kFunctions, DisplayPlugin<Driver>, __VA_ARGS__)

}  // namespace kinora
