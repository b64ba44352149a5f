# SPDX-License-Identifier: MIT
"""Family "books": nlme, lme and gnls fits of the data sets in R's nlme and MASS (Pinheiro and Bates 2000; Venables and Ripley 2002).

record_books.R has the R calls of the same names.
"""

import cases
import recorded

LOGISTIC = "Asym/(1 + exp((xmid - {x})/scal))"
FOUR_PARAMETERS = "B + (A - B)/(1 + exp((log(Dose) - ld50)/th))"
TWO_TERMS = "A1*exp(-exp(lrc1)*{x}) + A2*exp(-exp(lrc2)*{x})"
ABSORPTION = "conc ~ Dose*exp(lKe + lKa - lCl)*(exp(-exp(lKe)*Time) - exp(-exp(lKa)*Time))/(exp(lKa) - exp(lKe))"
OFFSET = "Asym*(1 - exp(-exp(lrc)*({x} - c0)))"
APPROACH = "Asym + (R0 - Asym)*exp(-exp(lrc)*{x})"
YEAR = "(Year == 1989) + (Year == 1990)"
TYPE = '(Type == "Mississippi") + (Treatment == "chilled") + (Type == "Mississippi" && Treatment == "chilled")'
FEMALE = '(Sex == "Female")'


def each(parameters, terms):
    return tuple(f"{parameter} ~ 1 + {terms}" for parameter in parameters)


# name: data, formula, random, and what else the case has
INDOMETH = ("Indometh", "conc ~ " + TWO_TERMS.format(x="time"))
SOYBEAN = ("Soybean", "weight ~ " + LOGISTIC.format(x="Time"))
ORANGE = ("Orange", "circumference ~ " + LOGISTIC.format(x="age"))
CO2 = ("CO2", "uptake ~ " + OFFSET.format(x="conc"))
DIALYZER = ("Dialyzer", "rate ~ " + OFFSET.format(x="pressure"))
LOBLOLLY = ("Loblolly", "height ~ " + APPROACH.format(x="age"))
CHICKS = ("ChickWeight", "weight ~ " + LOGISTIC.format(x="Time"))
RABBIT = ("Rabbit", "BPchange ~ " + FOUR_PARAMETERS)
CEFAMANDOLE = ("Cefamandole", "conc ~ " + TWO_TERMS.format(x="Time"))
SPRUCE = ("Spruce", "logSize ~ " + APPROACH.format(x="days"))
DIAGONAL = {"covariance": "diagonal"}
REML = {"options": ("--reml",), "methods": ("lb",)}

FITS = {
    "Indometh-1": (*INDOMETH, "A1 + lrc1 + A2 + lrc2 | Subject", DIAGONAL),
    "Indometh-2": (*INDOMETH, "A1 + lrc1 + A2 | Subject", DIAGONAL),
    "Indometh-3": (*INDOMETH, "A1 + lrc1 + A2 | Subject", {}),
    "Indometh-4": (*INDOMETH, "(A1 + lrc1) + A2 | Subject", {}),
    "Soybean-1": (*SOYBEAN, "Asym + xmid + scal | Plot", {}),
    "Soybean-2": (*SOYBEAN, "Asym + xmid + scal | Plot", {"variance": "power"}),
    "Soybean-3": (*SOYBEAN, "Asym + xmid + scal | Plot", {"variance": "power", "parameters": each(("Asym", "xmid", "scal"), YEAR)}),
    "Soybean-4": (*SOYBEAN, "Asym | Plot", {"variance": "power", "parameters": (
        f'Asym ~ 1 + {YEAR} + (Variety == "P") + (Year == 1989 && Variety == "P") + (Year == 1990 && Variety == "P")',
        f'xmid ~ 1 + {YEAR} + (Variety == "P")', f"scal ~ 1 + {YEAR}")}),
    "Orange-1": (*ORANGE, "Asym + xmid + scal | Tree", {}),
    "Orange-2": (*ORANGE, "Asym | Tree", {}),
    "Theoph-1": ("Theoph", ABSORPTION, "lKe + lKa + lCl | Subject", {}),
    "Theoph-2": ("Theoph", ABSORPTION, "lKe + lKa + lCl | Subject", DIAGONAL),
    "Theoph-3": ("Theoph", ABSORPTION, "lKa + lCl | Subject", DIAGONAL),
    "Theoph-4": ("Theoph", ABSORPTION, "lKa + lCl | Subject", {"variance": "constant-plus-power", **DIAGONAL}),
    "CO2-1": (*CO2, "Asym + lrc + c0 | Plant", {}),
    "CO2-2": (*CO2, "Asym + lrc | Plant", {}),
    "CO2-3": (*CO2, "Asym + lrc | Plant", {"parameters": each(("Asym",), TYPE)}),
    "CO2-4": (*CO2, "Asym + lrc | Plant", {"parameters": each(("Asym", "lrc"), TYPE)}),
    "CO2-5": (*CO2, "Asym | Plant", {"parameters": each(("Asym", "lrc"), TYPE)}),
    "Wafer-2": ("Wafer", "current ~ A + B*cos(w*voltage + 0.7853981633974483)",
                "A + A:voltage + A:v2 + B + w | Wafer; A + A:voltage + A:v2 + B | Wafer/Site",
                {"parameters": ("A ~ 1 + voltage + v2",), **DIAGONAL}),
    "Ovary": ("Ovary", "follicles ~ A + B*sin(6.283185307179586*w*Time) + C*cos(6.283185307179586*w*Time)", "A + B + w | Mare", DIAGONAL),
    "Dialyzer-1": (*DIALYZER, "", {"methods": ("ols",), "parameters": each(("Asym", "lrc"), "(QB == 300)")}),
    "Dialyzer-2": (*DIALYZER, "", {"methods": ("gnls",), "variance": "power(pressure)", "parameters": each(("Asym", "lrc"), "(QB == 300)")}),
    "Loblolly-1": (*LOBLOLLY, "Asym | Seed", {}),
    "Loblolly-2": (*LOBLOLLY, "Asym + lrc | Seed", DIAGONAL),
    "Loblolly-3": (*LOBLOLLY, "Asym + R0 + lrc | Seed", {}),
    "ChickWeight-1": (*CHICKS, "Asym | Chick", {}),
    "ChickWeight-2": (*CHICKS, "Asym + xmid | Chick", DIAGONAL),
    "ChickWeight-3": (*CHICKS, "Asym + xmid | Chick", {}),
    "ChickWeight-4": (*CHICKS, "Asym + xmid + scal | Chick", {"variance": "power"}),
    "ChickWeight-5": (*CHICKS, "Asym + xmid | Chick", {"variance": "power"}),
    "Rabbit-1": (*RABBIT, "A + ld50 | Animal/Run", {}),
    "Rabbit-2": (*RABBIT, "A + ld50 | Animal/Run", {"parameters": each(("A", "B", "ld50", "th"), '(Treatment == "MDL")')}),
    "Sitka": ("Sitka", "size ~ A + B*(1 - exp(-(Time - 100)/C))", "A + B | tree", {"parameters": each(("A", "B"), '(treat == "ozone")')}),
    "PBG": ("PBG", "deltaBP ~ A + (B - A)/(1 + exp((xmid - log(dose))/scal))", "B + xmid | Rabbit",
            {"parameters": ('xmid ~ 1 + (Treatment == "MDL 72222")',)}),
    "Cefamandole-1": (*CEFAMANDOLE, "A1 + lrc1 | Subject", DIAGONAL),
    "Cefamandole-2": (*CEFAMANDOLE, "A1 + lrc1 | Subject", {"variance": "power", **DIAGONAL}),
    "Spruce-1": (*SPRUCE, "Asym + R0 | Tree", {}),
    "Spruce-2": (*SPRUCE, "Asym | plot; Asym + R0 | Tree", {}),
    "Nitrendipene": ("Nitrendipene", "activity ~ A + (B - A)/(1 + exp((xmid - log(NIF))/scal))", "A | Tissue", {}),
    "Orthodont-1": ("Orthodont", "distance ~ b0 + b1*age", "b0 + b1 | Subject", {"parameters": each(("b0", "b1"), FEMALE), **REML}),
    "Orthodont-2": ("Orthodont", "distance ~ b0 + b1*age", "b0 + b1 | Subject",
                    {"variance": "stratum(Sex)", "parameters": each(("b0", "b1"), FEMALE)}),
    "Oxide": ("Oxide", "Thickness ~ m + 0*Site", "m | Lot/Wafer", REML),
    "Pixel-1": ("Pixel", "pixel ~ b0 + b1*day + b2*day2", "b0 + b1 | Dog; b0 | Dog/Side", {}),
    "Pixel-2": ("Pixel", "pixel ~ b0 + b1*day + b2*day2", "b0 + b1 | Dog; b0 | Dog/Side", REML),
    "BodyWeight": ("BodyWeight", "weight ~ b0 + b1*Time", "b0 + b1 | Rat",
                   {"variance": "power", "parameters": each(("b0", "b1"), "(Diet == 2) + (Diet == 3)")}),
    "Dialyzer-3": ("Dialyzer", "rate ~ b0 + b1*pressure + b2*p2 + b3*p3 + b4*p4", "b0 + b1 + b2 | Subject",
                   {"variance": "power(pressure)", "parameters": each(("b0", "b1", "b2", "b3", "b4"), "(QB == 300)")}),
    "RatPupWeight": ("RatPupWeight", "weight ~ b0", "b0 | Litter",
                     {"variance": "stratum(Treatment)", "parameters": (
                         'b0 ~ 1 + (sex == "Female") + (Treatment == "Low") + (Treatment == "High") + Lsize + '
                         '(sex == "Female" && Treatment == "Low") + (sex == "Female" && Treatment == "High")',)}),
    "IGF-1": ("IGF", "conc ~ b0 + b1*age", "b0 + b1 | Lot", {}),
    "IGF-2": ("IGF", "conc ~ b0 + b1*age", "b0 + b1 | Lot", {**DIAGONAL, **REML}),
    "Milk": ("Milk", "protein ~ b0 + b1*Time", "b0 + b1 | Cow", {}),
}

# Where a search may begin: the books' starts, and optima that were found by hand.
STARTS = {
    "Indometh": "A1=2.8,lrc1=0.77,A2=0.46,lrc2=-1.35",
    "Soybean": "Asym=19,xmid=55,scal=8",
    "Orange": "Asym=191.5,xmid=722,scal=344",
    "Theoph": "lKe=-2.43,lKa=0.45,lCl=-3.21",
    "CO2": "Asym=32.4,lrc=-4.56,c0=49.3",
    "Wafer": "A=-4.255,A:voltage=5.622,A:v2=1.258,B=-0.09555,w=4.5679",
    "Ovary": "A=12.18,B=-3.298,C=-0.862,w=1",
    "Loblolly": "Asym=103,R0=-8.5,lrc=-3.3",
    "ChickWeight": "Asym=368,xmid=20,scal=10",
    "Rabbit-1": "A=28,B=1.6,ld50=3.9,th=-0.25",
    "Rabbit-2": 'A=28,B=1.6,ld50=3.9,th=-0.25,A:(Treatment == "MDL")=0,B:(Treatment == "MDL")=0,ld50:(Treatment == "MDL")=0.5,'
                'th:(Treatment == "MDL")=0',
    "Sitka": 'A=2,B=4,C=100,A:(treat == "ozone")=0,B:(treat == "ozone")=0',
    "PBG": 'A=1,B=28,xmid=3.9,xmid:(Treatment == "MDL 72222")=0.5,scal=0.3',
    "Cefamandole": "A1=167,lrc1=-2.8,A2=54,lrc2=-4.2",
    "Spruce": "Asym=6.5,R0=3.5,lrc=-5",
    "Nitrendipene": "A=2000,B=100,xmid=-21,scal=1",
}


def family(_folder, _seed):
    nlme = recorded.log_likelihoods("books")
    for name, (data, formula, random, more) in FITS.items():
        start = STARTS.get(name, STARTS.get(data, "") if not more.get("parameters") or data == "Wafer" else "")
        settings = {"methods": cases.methods_for(random), **more}
        yield cases.Case(family="books", name=name, data=cases.FOLDER / "data-gpl" / f"{data}.csv", formula=formula, random=random,
                         nlme=nlme.get(name), starts={"the book's": start} if start else {}, **settings)
