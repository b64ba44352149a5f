// SPDX-License-Identifier: MIT
// Smooth random numbers over a plane, for clouds and for the floor of a forest.
#pragma once

namespace silvafit::render {

/// A smooth function of two coordinates with features of size 1, in [0, 1]; the same everywhere.
float value_noise(float x, float y);

/// A sum of octaves of it, each half as large and half as strong as the one before, in [0, 1].
float fractal_noise(float x, float y, int octaves);

}  // namespace silvafit::render
