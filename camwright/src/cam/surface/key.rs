// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Names of what describes a surface, for errors.

use crate::math::named::named;

named! {
    /// Number or list that describes a surface.
    SurfaceKey {
        Begin = "the z at which the part begins",
        End = "the z at which the part ends",
        CylinderRadius = "the radius of the cylinder",
        EccentricRadius = "the radius of the eccentric",
        Eccentricity = "the eccentricity",
        EccentricAzimuth = "the azimuth of the eccentric",
        FirstHalfAxis = "the first half axis",
        SecondHalfAxis = "the second half axis",
        HalfAxisAzimuth = "the azimuth of the first half axis",
        MeanRadius = "the mean radius",
        Harmonics = "harmonics",
        Waves = "the number of waves",
        WaveAmplitude = "the amplitude of a wave",
        WavePhase = "the phase of a wave",
        Cams = "cams",
        CamPhase = "the phase of a cam",
        CamBegin = "the z at which a cam begins",
        CamEnd = "the z at which a cam ends",
        CamRadius = "a radius of a cam",
        Azimuths = "azimuths",
        Rows = "rows",
        RowZ = "z of a row",
        Triangles = "triangles",
        SideTriangles = "triangles beside end faces",
        MeshCoordinate = "a coordinate of the mesh",
    }
}
