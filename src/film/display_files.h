// The writers of plain pictures that display drivers are lent (DisplayInfo::pictureFiles), over image/picture_file.h.
// Used by display_output.cpp.
#pragma once
#include <kinora/display.h>

namespace kinora::film {

const DisplayPictureFiles& displayPictureFiles();

}  // namespace kinora::film
