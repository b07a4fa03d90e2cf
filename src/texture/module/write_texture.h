// makeTexture(), on the library's side.
#pragma once
#include <string>

#include "texture/make_texture.h"

namespace kinora::texture {

MakeTextureResult writeTexture(const std::string& input, const std::string& output, const MakeTextureOptions& options,
                               std::string& why);

}  // namespace kinora::texture
