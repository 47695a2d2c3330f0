// Writes two pictures of equal size into one PNG, side by side.
#ifndef SIDE_BY_SIDE_HPP
#define SIDE_BY_SIDE_HPP

#include <png.h>

#include <array>
#include <cstdint>
#include <vector>

// Red, green, blue, and a fourth channel that is ignored.
using Picture = std::vector<std::array<uint8_t, 4>>;

inline bool write_side_by_side(const char *path, uint32_t width, const Picture &left, const Picture &right) {
    std::vector<uint8_t> rgb;
    for (size_t row = 0; row < left.size(); row += width)
        for (const Picture *picture : {&left, &right})
            for (size_t i = row; i < row + width; ++i)
                rgb.insert(rgb.end(), (*picture)[i].begin(), (*picture)[i].begin() + 3);
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = 2 * width;
    image.height = uint32_t(left.size() / width);
    image.format = PNG_FORMAT_RGB;
    return png_image_write_to_file(&image, path, 0, rgb.data(), 0, nullptr) != 0;
}

#endif
