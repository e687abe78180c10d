"""Where birds were published to fly, as a table of places."""

import pytest
from upwash import load_species
from upwash.errors import UpwashError
from upwash.study.observations import OBSERVATIONS, read_observations
from upwash.study.observed.file import PUBLISHED, read_birds, read_pieces
from upwash.study.observed.published import is_published, published_places
from upwash.study.observed.published_savings import (
    SAVINGS,
    SPECIES,
    published_savings,
    read_published_savings,
)

KEPT = read_published_savings()


def places(name):
    return published_places(name, load_species(name).bird(), read_observations())


def test_wingtip_spacings_and_lengths_in_wingspans_become_metres():
    wingspan = 2.0 * load_species("canada-goose").bird().semispan_m
    found = places("canada-goose").set_index("label")
    assert found.loc["Hainsworth 1987", "y_m"] == pytest.approx(wingspan - 0.198)
    assert found.loc["Hainsworth 1987", "x_m"] == pytest.approx(wingspan)
    assert found.loc["Hainsworth 1987", "assumed"] == "one wingspan behind, level"
    wingspan = 2.0 * load_species("dunlin").bird().semispan_m
    dunlin = places("dunlin").iloc[0]
    # Half to one and a half wingspans behind, one aside, in the same plane: all published.
    assert (dunlin["x_m"], dunlin["y_m"], dunlin["z_m"]) == pytest.approx((wingspan, wingspan, 0.0))
    assert dunlin["assumed"] == ""


def test_what_this_model_computed_is_no_observation():
    assert set(places("northern-bald-ibis")["label"]) == {"Portugal 2014"}


def test_the_file_is_found_anywhere_and_read_as_it_stands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bird = load_species("greylag-goose").bird()
    (by_name,) = read_birds(PUBLISHED, "greylag-goose", bird)
    (by_path,) = read_birds(OBSERVATIONS, "greylag-goose", bird)
    assert by_name.equals(by_path) and by_name.equals(places("greylag-goose"))
    assert is_published(next(read_pieces(OBSERVATIONS)))
    assert not is_published(by_name)


def test_a_species_without_a_published_place_is_one_line():
    with pytest.raises(UpwashError, match="common-starling, dunlin, greylag-goose.*found mute-swan") as error:
        places("mute-swan")
    assert "brown-pelican" not in str(error.value)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "dunlin" else pytest.mark.thorough) for name in SPECIES]
)
def test_what_is_kept_is_what_comes_out(name):
    found, kept = published_savings([name]), KEPT[KEPT["species"] == name].reset_index(drop=True)
    assert list(found) == list(kept) == list(SAVINGS)
    for column in SAVINGS:
        if found[column].dtype.kind == "f":
            # The best phase may lie anywhere where the saving hardly depends on it.
            tolerance = 1e-3 if column == "phase" else 2e-6
            assert found[column].to_numpy() == pytest.approx(kept[column].to_numpy(), abs=tolerance), column
        else:
            assert list(found[column]) == list(kept[column])


def test_all_species_of_which_a_place_is_published_are_kept():
    assert set(KEPT["species"]) == set(SPECIES)
    observations = read_observations()
    for name in set(observations["species"]) - set(SPECIES):
        with pytest.raises(UpwashError):
            published_places(name, load_species(name).bird(), observations)
