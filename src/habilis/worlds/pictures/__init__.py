"""Pictures of worlds: shapes, figures, heatmaps, tiles, video."""
