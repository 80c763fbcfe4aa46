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
    /// A row has this many cells, >= 0; 0: about as wide as a page.
    int columns = 0;
    /// A cell is this wide [px]; in [16, 4096].
    int cell_width = 200;
    /// The raster has this many pixels a px; in [1, 4].
    int scale = 2;
    /// Meshes are seen from here; none: automatic_view() of the first mesh.
    std::optional<ViewDirection> view = {};
    /// Each mesh is moved onto the one before; else onto the first.
    bool is_sequence = false;
    /// Each mesh is coloured by #V values, grey where one is NaN; empty: none is.
    std::vector<Eigen::VectorXd> values = {};
    /// Values have these colours.
    ColourMap colour_map = ColourMap::Sequential;
    /// This value has the first colour; finite.
    double value_low = 0.0;
    /// This value has the last colour; finite, > value_low.
    double value_high = 1.0;
    /// This stands at the colour bar.
    std::string value_name = {};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const PictureOptions& options);

/// A sheet of meshes and their captions.
struct Picture
{
    Image sheet; ///< `scale` pixels a px; no text.
    int scale = 1;
    struct Caption
    {
        double x = 0.0; ///< Its middle is here [px].
        double y = 0.0; ///< Its base line is here [px].
        double size =
            12.0; ///< Its letters are this high [px]: less where they would leave the cell.
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
    std::optional<ColourBar> colour_bar; ///< Stands below a picture coloured by values.

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
