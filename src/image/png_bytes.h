// A picture as the bytes of a PNG file, for pages that carry their pictures inside. Used by the statistics page.
// Files are read_write.h's.
#pragma once
#include <vector>

#include "image/image.h"
#include "image/status.h"

namespace kinora::image {

// The first three channels (or one), 8 bits. `encodeSrgb`: they are scene-linear; else values are codes / 255.
Status pngBytes(const Image& image, bool encodeSrgb, std::vector<unsigned char>& out);

}  // namespace kinora::image
