// The interface of a display driver: it is given a finished picture as floats and writes it. One instance writes one
// picture: Descriptor::create opens (CreateInfo::extra is a DisplayInfo), then write once, then close or abort, then
// destroy. A snapshot during the render is a whole new instance. Called by one thread at a time.
// A driver that makes a file writes to DisplayInfo::writePath, a temporary name beside the target; the host renames
// it when close() says that all is written, and removes it otherwise, so a target is always whole. The driver must
// report what the disk refuses (check the last flush too). Drivers that show or send the picture leave writePath
// alone.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

enum class DisplayPixelType : uint32_t { Half, Float };

struct DisplayChannelInfo {
  const char* name;       // as the file should call it: "R", "A", "Z", "diffuse.G", "id"
  DisplayPixelType type;  // what the data needs: colours Half, depths, positions and ids Float
  // 1: scene-linear colour (8-bit formats encode it); 0: alpha or data; 2: a colour that is encoded already, given
  // only to drivers with a string parameter "view" when it names a view of the colour configuration.
  uint32_t isColor;
};

enum class DisplayMetadataType : uint32_t { Int, Float, String, Matrix };

struct DisplayMetadata {
  const char* key;
  DisplayMetadataType type;
  int32_t integer;
  float number;
  const char* text;
  const float* matrix;  // 16 floats, row-major, row vectors
};

// What a value is in a file of a plain picture.
enum class DisplayCode : uint32_t { UInt8, UInt16, Float };

// A file that DisplayPictureFiles shall write. What it points to is read by open().
struct DisplayPictureFormat {
  const char* format;      // "png", "jpeg", "tiff"
  const char* path;        // DisplayInfo::writePath
  int32_t window[4];       // x0 y0 x1 y1, x1 and y1 excluded
  uint32_t resolution[2];  // of the full picture
  uint32_t channelCount;
  const char* const* channelNames;    // null: as the format calls so many
  int32_t alphaChannel;               // of named ones; -1: none
  DisplayCode code;                   // of all values
  const DisplayMetadata* attributes;  // as OpenImageIO names them, whose writers these are
  uint32_t attributeCount;
};

// The renderer's own writers of plain pictures, for drivers. Null or 0 come with a text.
struct DisplayPictureFiles {
  void* (*open)(const DisplayPictureFormat* format, ErrorText* error);
  // Rows of the window from its top, in order; pixels without gaps between them.
  int (*write)(void* file, uint32_t firstRow, uint32_t rowCount, const void* pixels, ErrorText* error);
  int (*close)(void* file, ErrorText* error);  // 1: the file is whole and on its way to the disk
  void (*destroy)(void* file);                 // after close(), or instead of it
};

// CreateInfo::extra. All but `pictureFiles` is valid until create() returns.
struct DisplayInfo {
  const char* file;        // what the user asked for; for messages
  const char* writePath;   // where to write
  uint32_t resolution[2];  // the full picture
  int32_t window[4];       // x0 y0 x1 y1: the pixels that are given, x1 and y1 excluded
  float pixelAspect;
  const DisplayChannelInfo* channels;
  uint32_t channelCount;
  const DisplayMetadata* metadata;
  uint32_t metadataCount;
  // What the picture shows of the plane at distance 1 from the camera, along its axis (orthographic: of any): centre,
  // to the right and up, and width. Width 0: not known.
  float screenWindow[3];
  const DisplayPictureFiles* pictureFiles;
};

// All pixels of the window. Value of channel c at window-relative (x, y): channels[c][y * rowStride + x *
// pixelStride].
struct DisplayPixels {
  const float* const* channels;
  size_t pixelStride, rowStride;  // in floats
};

// Functions return 1 when all went well, else 0 with a text.
struct DisplayFunctions {
  int (*write)(void* display, const DisplayPixels* pixels, ErrorText* error);
  int (*close)(void* display, ErrorText* error);  // everything is on its way to the disk
  void (*abort)(void* display);                   // instead of close: forget the picture
};

// Descriptor::traits; null: all 0.
struct DisplayTraits {
  // 1: the format keeps colours apart from alpha. They come divided by it then, before exposure, view and dither.
  // Else they come as the renderer has them, multiplied (on black).
  int32_t straightAlpha;
  int32_t pictureFiles;  // 1: DisplayInfo::pictureFiles are used; that they can be is found out before rendering
};

// The metadata "colorSpace" says what the codes of a format of integers mean once colours of isColor 1 are
// sRGB-encoded: "sRGB", "gamma 2.2" (an exposure has encoded them so), the name of a view, or that and the working
// space where it is another than sRGB's. Formats of floats get the working space.

// A driver has one function table, of width 1; <kinora/display_author.h> makes it.

}  // namespace kinora
