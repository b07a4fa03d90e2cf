// The numbers of a grade, as the pattern and the filters of that name have them.
#pragma once
#include <kinora/plugin.h>

#include <array>

namespace kinora::gradeParams {

inline constexpr std::array kGrade = {
    param::color("blackPoint", 0.f).help("Becomes black."),
    param::color("whitePoint", 1.f).help("Becomes white."),
    param::color("lift", 0.f).range(-1, 1).help("Added after the gain."),
    param::color("gain", 1.f).range(0, 4).help("Factor."),
    param::color("multiply", 1.f).range(0, 4).help("Factor."),
    param::color("offset", 0.f).range(-1, 1).help("Added after the gain."),
    param::color("gamma", 1.f)
        .range(0.1f, 4)
        .help("The colour becomes itself to the power 1 / gamma; 1 changes nothing."),
    param::onOff("clampBlack", true).help("Cuts negative colours."),
    param::onOff("clampWhite", false).help("Cuts colours above 1."),
    param::color("mask", 1.f).help("0 keeps the colour, 1 grades it."),
};

}  // namespace kinora::gradeParams
