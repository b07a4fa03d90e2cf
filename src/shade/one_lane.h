// Elementary functions of a single number, for code that is not wide: those of kinora/math/elementary.h, so that the
// bits are the same with every C library.
#pragma once

namespace kinora::shade::oneLane {

float exp(float x);
float log(float x);
float tan(float x);
float atan(float x);
float atan2(float y, float x);
float asin(float x);

}  // namespace kinora::shade::oneLane
