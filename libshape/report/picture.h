// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/mesh/collection.h"
#include "libshape/report/colour_map.h"
#include "libshape/report/plot.h"
#include "libshape/report/render.h"

namespace shape {

struct PictureOptions
{
    int columns = 0;                   ///< Cells in a row; 0: about as wide as a page.
    int cell_width = 200;              ///< [px], in [16, 4096].
    int scale = 2;                     ///< Pixels of the raster a px; in [1, 4].
    std::optional<ViewDirection> view; ///< None: automatic_view of the first mesh.
    bool is_sequence = false;          ///< Each mesh is moved onto the one before; else the first.
    std::vector<Eigen::VectorXd> values; ///< Empty, or per mesh #V values to colour it by.
    ColourMap colour_map = ColourMap::Sequential;
    double value_low = 0.0;  ///< Value of the first colour.
    double value_high = 1.0; ///< Value of the last colour; > value_low.
    std::string value_name;  ///< Stands at the colour bar.
};

/// A sheet of meshes and their captions.
struct Picture
{
    Image sheet; ///< `scale` pixels a px; no text.
    int scale = 1;
    struct Caption
    {
        double x = 0.0;     ///< Of its middle [px].
        double y = 0.0;     ///< Of its base line [px].
        double size = 12.0; ///< Of its letters [px]: smaller where they would leave the cell.
        std::string text;
    };
    std::vector<Caption> captions;
    struct ColourBar
    {
        ColourMap map = ColourMap::Sequential;
        double low = 0.0;
        double high = 1.0;
        std::string name;
    };
    std::optional<ColourBar> colour_bar; ///< Of a picture coloured by values; stands below it.

    [[nodiscard]] double width() const { return static_cast<double>(sheet.width) / scale; }
    [[nodiscard]] double height() const { return static_cast<double>(sheet.height) / scale; }
};

/// Draws the meshes of a collection, all from one side and at one scale, each moved rigidly onto the
/// first or, in a sequence, the one before.
/// @param progress  Called with the meshes drawn.
/// @throws InvalidInput if an option is out of its range or values do not fit the meshes;
///     LimitExceeded if the sheet would have more than 2^28 pixels.
[[nodiscard]] Picture draw_collection(const Collection& collection,
                                      const PictureOptions& options = {},
                                      const Progress& progress = {});

/// The picture as SVG, the sheet embedded as PNG, captions and the colour bar as text.
[[nodiscard]] std::string picture_svg(const Picture& picture);

/// The picture above a plot as one SVG.
[[nodiscard]] std::string overview_svg(const Picture& picture, const Plot& plot);

} // namespace shape
